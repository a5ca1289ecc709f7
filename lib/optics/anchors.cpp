// Method: time is divided into intervals of plan.anchor_days; interval i has its expansion point at the orbital
// position of its middle, (i + 1/2) anchor_days. An anchor depends on i alone, so a frame has the same bits whether its
// anchor was cached or computed again.
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
        std::find_if(cache_.begin(), cache_.end(), [number](const auto &cached) { return cached.first == number; });
    std::shared_ptr<const Anchor> anchor;
    if (found != cache_.end()) {
        anchor = found->second;
        cache_.erase(found);
    } else {
        anchor = std::make_shared<Anchor>(make((static_cast<double>(number) + 0.5) * plan_.anchor_days));
    }
    cache_.emplace_front(number, anchor);
    if (cache_.size() > kCachedAnchors)
        cache_.pop_back();
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
            detector_.apply_response(derivative.image);
        anchor.star[s] = std::move(images.derivatives[0].image);
        images.derivatives.erase(images.derivatives.begin());
        anchor.position_derivatives[s] = std::move(images.derivatives);
        if (!disturbed)
            continue;
        add(images.scale, anchor.scale);
        add(images.focus, anchor.focus);
        add(images.focus_curve, anchor.focus_curve);
    }
    for (Buffer<double> *image : {&anchor.scale, &anchor.focus, &anchor.focus_curve})
        if (!image->empty())
            detector_.apply_response(*image);
    return anchor;
}

} // namespace toliman::optics
