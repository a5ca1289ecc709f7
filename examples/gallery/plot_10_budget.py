"""
What limits the precision
=========================

An error budget tells which unknown parameters of the telescope hide a planet, and by how much each must be known.
"""
# %%
# The budget of a scene with fluxes and pointing free in each frame.
import toliman

simulator = toliman.Simulator("../data/moving.json")
budget = simulator.budget(["flux_a", "flux_b", "shift_x", "shift_y"], frames=100)
budget.plot()

# %%
# The five parameters whose errors weigh most: the amount by which each biases the separation by a tenth of the Cramer-Rao
# bound.
worst = sorted((row for row in budget.rows if not row.is_free), key=lambda row: row.tenth_crb_amount)
for row in worst[:5]:
    print(f"{row.name:14} {row.tenth_crb_amount:.2g} {row.unit}")

# %%
# Results are frozen dataclasses, and lists of them become tables with units, of astropy or pandas, which write ECSV, FITS
# and more.
table = toliman.Rows(worst[:5]).to_table()
table
