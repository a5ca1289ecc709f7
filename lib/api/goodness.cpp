// include/toliman/goodness.h
#include "api/goodness.hpp"

using namespace toliman;
using namespace toliman::api;

const char *toliman_goodness_name(int32_t goodness) noexcept {
    return kGoodness.contains(goodness) ? name_of(kGoodness.to_enum(goodness, "goodness")) : "?";
}
