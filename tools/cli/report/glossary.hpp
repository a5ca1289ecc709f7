// What words mean that several kinds of page have.
#pragma once
#include "report/page.hpp"

namespace cli {

inline const Word kBoundWord = {"Cram&eacute;r-Rao bound",
                                "the least scatter that a number from the photons of one frame can have"};
inline const Word kFapWord = {
    "FAP", "false alarm probability: how often noise alone has so high a peak somewhere on the grid; "
           "log<sub>10</sub> FAP &minus;3 is once in a thousand series"};
inline const Word kFwhmWord = {"FWHM", "full width of the peak at half its height"};

} // namespace cli
