// Pixels that are brighter, compared with their neighbours, than the image of a star can be.
#pragma once
#include "base/buffer.hpp"
#include "base/view.hpp"
#include "kernels/normal.hpp"

namespace toliman::fit {

// Copies the counts to `out` [rows][cols], each spike replaced by the mean of its neighbours. False, with `out`
// untouched or incomplete, if there are none, or more than kMostBadPixels.
bool remove_spikes(const ImageView<const double> &counts, const kernels::CountModel &how, Buffer<double> &out);

} // namespace toliman::fit
