// Constants of cae.h that other headers use, too.
#pragma once
#include <toliman/cae.h>

#include "api/choice.hpp"
#include "cae/layout.hpp"
#include "cae/payload.hpp"

namespace toliman::api {

constexpr Choice<cae::Encoding> kEncodings = {TOLIMAN_CAE_ENCODING_FLOAT32, TOLIMAN_CAE_ENCODING_FP16,
                                              "TOLIMAN_CAE_ENCODING_..."};

// layout: of accepted options.
inline const cae::Layout &layout_of(int32_t layout) {
    enum class Name { flight, paper };
    constexpr Choice<Name> names = {TOLIMAN_CAE_LAYOUT_FLIGHT, TOLIMAN_CAE_LAYOUT_PAPER, "TOLIMAN_CAE_LAYOUT_..."};
    return names.to_enum(layout) == Name::flight ? cae::kFlight : cae::kPaper;
}

} // namespace toliman::api
