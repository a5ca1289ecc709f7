// Goodness of fit of frames, in the caller's array.
#pragma once
#include <optional>
#include <vector>

#include "api/goodness.hpp"
#include "api/struct_array.hpp"

namespace toliman::api {

// Takes what the estimators find; deliver() writes it to an array that may be NULL.
class FramesGoodness {
  public:
    FramesGoodness(toliman_frame_goodness *first, size_t count) {
        if (first == nullptr)
            return;
        out_.emplace(first, "goodness");
        if (count > 1)
            many_.resize(count);
    }
    // [count], or NULL.
    FrameGoodness *found() noexcept { return !out_ ? nullptr : many_.empty() ? &one_ : many_.data(); }
    void deliver() const noexcept {
        for (size_t i = 0; out_ && i < (many_.empty() ? 1 : many_.size()); i++) {
            toliman_frame_goodness whole = {};
            set_frame_goodness(many_.empty() ? one_ : many_[i], whole);
            out_->put(i, whole);
        }
    }

  private:
    std::optional<StructArray<toliman_frame_goodness>> out_;
    FrameGoodness one_; // of a single frame, for which nothing is allocated
    std::vector<FrameGoodness> many_;
};

} // namespace toliman::api
