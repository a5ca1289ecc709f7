// Constants of cae.h that other headers use, too.
#pragma once
#include <toliman/cae.h>

#include "api/choice.hpp"
#include "cae/layout.hpp"
#include "cae/payload.hpp"

namespace toliman::api {

constexpr Choice<cae::Encoding> kEncodings = {TOLIMAN_CAE_ENCODING_FLOAT32, TOLIMAN_CAE_ENCODING_FP16,
                                              "TOLIMAN_CAE_ENCODING_..."};

// layout: of accepted options; 0: by the size of the frames.
inline const cae::Layout &layout_of(int32_t layout, size_t rows, size_t cols) {
    enum class Index { flight, paper, core };
    constexpr Choice<Index> indices = {TOLIMAN_CAE_LAYOUT_FLIGHT, TOLIMAN_CAE_LAYOUT_CORE, "TOLIMAN_CAE_LAYOUT_..."};
    return layout == 0 ? cae::default_layout(rows, cols) : *cae::kLayouts[static_cast<size_t>(indices.to_enum(layout))];
}

} // namespace toliman::api
