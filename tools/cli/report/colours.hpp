// Colour maps that the colour-blind can read, and pictures made with them.
#pragma once
#include <string>
#include <vector>

namespace cli {

enum class Palette {
    intensity, // viridis, dark to bright
    difference // blue to red over white; its middle is 0
};

struct Scale {
    Palette palette = Palette::intensity;
    double low = 0, high = 1; // values of the first and the last colour; those beyond take these
    bool log = false;         // colours go by the logarithm
};

// A PNG file of values[rows][cols], a pixel each, row 0 at the bottom as the axes have it; grey what is no number.
std::string png_of(const std::vector<double> &values, size_t rows, size_t cols, const Scale &scale);
// gnuplot's commands for the same colours, and range, in a colour box.
std::string colour_box(const Scale &scale);

// Of lines: nine that look different to everyone (six of Okabe and Ito 2008), then the same again.
const char *line_colour(size_t i);
// Marker and colour, in gnuplot's words: where colours come again, their markers are others, up to 45 pairs.
std::string mark(size_t i);

} // namespace cli
