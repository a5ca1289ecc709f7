"""The orbit and the planets of a state folder of `toliman track --fit --system`: state.py FOLDER OBSERVER_FILE."""
import sys

import toliman

better, fit = toliman.Sky("alpha-cen", sys.argv[2]).refit(toliman.Measurements(sys.argv[1], kind="separation"))
found = toliman.planets(toliman.Measurements(sys.argv[1]))
print(f"orbit: chi-square {fit.chi_square:.3f}; {len(found.planets)} planets")
