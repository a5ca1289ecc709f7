"""Compares detection methods over a range of signal amplitudes, with controls: `python3 -m toliman.experiment --help`.

    __main__   command line and files
    campaign   gives the frames of each table, amplitude and seed to all methods
    methods    turn frames into values
    variants   scenes that differ from the given one
    journal    every result as soon as it is known, from which a stopped experiment resumes
    summary    medians over the seeds, and the controls; tables: as JSON, CSV and Markdown
    theory     results expected at the Cramer-Rao bound
"""
