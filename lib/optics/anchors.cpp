#include "optics/anchors.hpp"

#include <algorithm>
#include <cmath>

namespace toliman::optics {

namespace {

void add(const Buffer<double> &part, Buffer<double> &sum) {
    sum.resize(part.size());
    for (size_t i = 0; i < part.size(); i++)
        sum[i] += part[i];
}

} // namespace

std::shared_ptr<const Anchor> Anchors::near(double days) const {
    const auto number = static_cast<int64_t>(std::floor(days / plan_.anchor_days));
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found =
        std::find_if(kept_.begin(), kept_.end(), [number](const auto &kept) { return kept.first == number; });
    std::shared_ptr<const Anchor> anchor;
    if (found != kept_.end()) {
        anchor = found->second;
        kept_.erase(found);
    } else {
        anchor = std::make_shared<Anchor>(make((static_cast<double>(number) + 0.5) * plan_.anchor_days));
    }
    kept_.emplace_front(number, anchor);
    if (kept_.size() > kKeptAnchors)
        kept_.pop_back();
    return anchor;
}

Anchor Anchors::make(double days) const {
    Anchor anchor;
    Light light = light_;
    light.offset_px = anchor.offset_px = offsets_at(scene_, light_, days);
    const bool disturbed = scene_.systematics.scale.any() || scene_.systematics.focus_nm.any();
    for (size_t s = 0; s < scene_.stars.size(); s++) {
        StarImages images = imager_.images(light, s, 0, {0, plan_.place_order, disturbed, disturbed});
        for (Derivative &derivative : images.derivatives)
            detector_.collect(derivative.image);
        anchor.star[s] = std::move(images.derivatives[0].image);
        images.derivatives.erase(images.derivatives.begin());
        anchor.places[s] = std::move(images.derivatives);
        if (!disturbed)
            continue;
        add(images.scale, anchor.scale);
        add(images.focus, anchor.focus);
        add(images.focus_curve, anchor.focus_curve);
    }
    for (Buffer<double> *image : {&anchor.scale, &anchor.focus, &anchor.focus_curve})
        if (!image->empty())
            detector_.collect(*image);
    return anchor;
}

} // namespace toliman::optics
