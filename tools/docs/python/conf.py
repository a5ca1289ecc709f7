"""Sphinx: the gallery of examples in Python, executed. GALLERY: the folder of the examples."""
import os
import warnings

from sphinx_gallery.sorting import FileNameSortKey

project, copyright = "toliman", "the libtoliman authors"
version = release = os.environ["VERSION"]
extensions = ["sphinx_gallery.gen_gallery"]
html_theme, html_show_sourcelink = "alabaster", False
html_theme_options = {"description": "planets of alpha Centauri in frames of TOLIMAN", "page_width": "1300px"}
warnings.filterwarnings("ignore", "Matplotlib is currently using agg")
sphinx_gallery_conf = {
    "examples_dirs": os.environ["GALLERY"], "gallery_dirs": "gallery", "within_subsection_order": FileNameSortKey,
    "abort_on_example_error": True, "ignore_repr_types": r"matplotlib\.", "show_memory": False, "download_all_examples": False,
}
