"""Reports: figures and HTML pages of what the commands run, experiment, period, track and `make bench` wrote.

    python3 -m toliman.report chapter.run                # chapter.run/report/report.html

    from toliman.report import figures                   # matplotlib figures of arrays, for notebooks
    figures.training(steps, losses).savefig("training.pdf")

Needs numpy, matplotlib and Jinja2 (Debian: python3-numpy, python3-matplotlib, python3-jinja2). Only result files are
read, as documented in formats.md; libtoliman is not loaded.
"""
