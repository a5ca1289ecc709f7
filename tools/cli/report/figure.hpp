// Figures: a script for gnuplot, drawn once as SVG and once as PNG.
#pragma once
#include <string>
#include <vector>

#include "report/colours.hpp"

namespace cli {

using Numbers = std::vector<double>;

constexpr int kFigureWidth = 900; // px, all of them

struct Figure {
    std::string name;                  // of its files; what is no letter, digit or - becomes -
    std::string caption;               // HTML
    int height = 0;                    // px
    std::string script;                // what is common to both kinds of files
    std::vector<std::string> pictures; // PNG files that it shows
};

enum class FileKind { svg, png };
std::string drawn(const Figure &figure, FileKind kind);

// An image among others of a figure: values[rows][cols], its pixel [0][0] at (x, y), pixels `step` wide.
struct Panel {
    std::string title;
    Numbers values;
    size_t rows = 0, cols = 0;
    double x = 0, y = 0, step = 1;
    std::string axis_unit;  // "px"
    std::string value_unit; // beside the colour box; empty where the next panel's box holds for this one too
    Scale scale;
};

// Panels side by side, square pixels, a colour box for each scale.
Figure panel_figure(const std::string &name, const std::string &caption, const std::vector<Panel> &panels);

// Margins of plot i of `count`, one above the other with one axis below, the first on top.
std::string stacked(size_t i, size_t count, const Figure &figure, double right = 18);

// Rows of numbers that the script calls $NAME; what is not finite is left out of lines.
std::string data_block(const std::string &name, const std::vector<const Numbers *> &columns);

} // namespace cli
