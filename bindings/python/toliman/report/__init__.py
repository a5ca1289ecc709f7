"""Reports: figures and HTML pages of what run, experiment, period, pupil, track and `make bench` wrote.

    python3 -m toliman.report chapter.run                # chapter.run/report/report.html

    from toliman.report import figures                   # matplotlib figures of arrays, for notebooks
    figures.training(steps, losses).savefig("training.pdf")

Needs numpy, matplotlib and Jinja2 (Debian: python3-numpy, python3-matplotlib, python3-jinja2). Result files are
read, as documented in formats.md; libtoliman is loaded only for folders of toliman run and pupil, to simulate their scenes.
"""
