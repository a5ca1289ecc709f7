"""Terms that several sections explain at the end of the page."""
BOUND = {"Cramér-Rao bound": "the smallest scatter that an unbiased estimate from the photons of one frame can have"}
FAP = {"FAP": "false alarm probability: how often noise alone has a peak this high anywhere on the grid; log₁₀ FAP = "
              "−3 means once in a thousand series"}
FWHM = {"FWHM": "full width of the peak at half its height; the error of a period is much smaller than this width"}
PEAKS = {"fit, grid peak": "fit: period of the sinusoid that fits best (least squares), with its standard error; grid "
                           "peak: the grid's frequency of highest power"}
