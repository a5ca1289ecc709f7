// The frames of a tracker as a series.
#pragma once
#include "measure/series.hpp"
#include "track/tracker.hpp"

namespace toliman::measure {

// The accepted frames in order of arrival, with the values, the functions and the priors of the sums; reduced ones if
// the tracker reduces. plain: times in units of the grid. Status::not_found if there is none.
Series values_of(const track::Tracker &tracker, const period::Grid &grid, bool plain);

// The measured separations, px, of the accepted and the unreduced frames whose time on target is known, with their
// exposures; those whose time on target is not known count in left_out. Status::not_found if the tracker has no
// separations, or no such frame.
Series separations_of(const track::Tracker &tracker);

} // namespace toliman::measure
