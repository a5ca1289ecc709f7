#include "report/figure.hpp"

#include <algorithm>
#include <cmath>

#include "report/gnuplot.hpp"
#include "report/words.hpp"

namespace cli {

namespace {

constexpr int kPngScale = 2; // its pixels per px of the SVG
constexpr const char *kCommon = "set encoding utf8\n"
                                "set border lc rgb '#444444' lw 0.8\n"
                                "set tics nomirror scale 0.6 tc rgb '#222222'\n"
                                "set grid lc rgb '#dddddd' lw 0.5 lt 1\n"
                                "set key top right noenhanced\n";

std::string terminal(FileKind kind, int height) {
    if (kind == FileKind::svg)
        return printed("set terminal svg size %d,%d enhanced font 'sans-serif,12' background 'white'\n", kFigureWidth,
                       height);
    return printed("set terminal pngcairo size %d,%d enhanced font 'sans-serif,9' fontscale %d linewidth %d "
                   "pointscale %d background 'white'\n",
                   kPngScale * kFigureWidth, kPngScale * height, kPngScale, kPngScale, kPngScale);
}

// Distances in px.
constexpr double kLeft = 62, kNext = 16, kBox = 12, kBoxGap = 8, kBoxLabels = 66, kTop = 30, kBottom = 52, kMost = 330;

// Axes are labelled where they are not those of the panel before.
bool has_own_axis(const std::vector<Panel> &panels, size_t i) {
    return i == 0 || panels[i].x != panels[i - 1].x || panels[i].step != panels[i - 1].step ||
           panels[i].rows != panels[i - 1].rows || panels[i].axis_unit != panels[i - 1].axis_unit;
}

bool has_box(const Panel &panel) {
    return !panel.value_unit.empty();
}

double room_beside(const std::vector<Panel> &panels) {
    double room = 0;
    for (size_t i = 0; i < panels.size(); i++)
        room += (has_own_axis(panels, i) ? kLeft : kNext) + (has_box(panels[i]) ? kBoxGap + kBox + kBoxLabels : 0);
    return room;
}

std::string panel_script(const Panel &panel, size_t number, double left, double side, double height, bool own_axis) {
    const double right = left + side, bottom = kBottom / height, top = (height - kTop) / height;
    const double width = kFigureWidth, rows = static_cast<double>(panel.rows), cols = static_cast<double>(panel.cols);
    std::string text = printed("set lmargin at screen %.6f\nset rmargin at screen %.6f\n"
                               "set bmargin at screen %.6f\nset tmargin at screen %.6f\n",
                               left / width, right / width, bottom, top);
    text += "set title " + gnuplot_text(panel.title) + " offset 0,-0.6\n";
    text += "set xlabel " + gnuplot_text("x, " + panel.axis_unit) + " offset 0,0.3\n";
    text += own_axis ? "set ylabel " + gnuplot_text("y, " + panel.axis_unit) + " offset 1.2,0\nset format y '%g'\n"
                     : "unset ylabel\nset format y ''\n";
    const double half = panel.step / 2;
    text += printed("set xrange [%.10g:%.10g]\nset yrange [%.10g:%.10g]\n", panel.x - half,
                    panel.x + (cols - 0.5) * panel.step, panel.y - half, panel.y + (rows - 0.5) * panel.step);
    text += colour_box(panel.scale);
    text += panel.scale.log ? "set format cb '10^{%T}'\n" : "set format cb '%g'\n";
    if (has_box(panel))
        text += printed("set colorbox user origin screen %.6f,%.6f size screen %.6f,%.6f border\n",
                        (right + kBoxGap) / width, bottom, kBox / width, top - bottom) +
                "set cblabel " + gnuplot_text(panel.value_unit) + " offset 0.3,0\n";
    else
        text += "unset colorbox\nunset cblabel\n";
    return text + printed("plot '%s' binary filetype=png dx=%.10g dy=%.10g origin=(%.10g,%.10g) with rgbimage notitle, "
                          "NaN with points palette notitle\n",
                          picture_name(number).c_str(), panel.step, panel.step, panel.x, panel.y);
}

} // namespace

std::string drawn(const Figure &figure, FileKind kind) {
    return drawn(terminal(kind, figure.height) + kCommon + figure.script + "unset output\n", figure.pictures);
}

Figure panel_figure(const std::string &name, const std::string &caption, const std::vector<Panel> &panels) {
    const double room = room_beside(panels), count = static_cast<double>(panels.size());
    const double side = std::min(kMost, (kFigureWidth - room) / count);
    double tallest = 0;
    for (const Panel &panel : panels)
        tallest = std::max(tallest, static_cast<double>(panel.rows) / static_cast<double>(panel.cols));
    Figure figure;
    figure.name = name;
    figure.caption = caption;
    figure.height = static_cast<int>(std::ceil(side * tallest + kTop + kBottom));
    figure.script = "unset grid\nset tics out\nset multiplot\n";
    double left = (kFigureWidth - room - side * count) / 2;
    for (size_t i = 0; i < panels.size(); i++) {
        const bool own_axis = has_own_axis(panels, i);
        left += own_axis ? kLeft : kNext;
        figure.pictures.push_back(png_of(panels[i].values, panels[i].rows, panels[i].cols, panels[i].scale));
        figure.script += panel_script(panels[i], i, left, side, figure.height, own_axis);
        left += side + (has_box(panels[i]) ? kBoxGap + kBox + kBoxLabels : 0);
    }
    figure.script += "unset multiplot\n";
    return figure;
}

std::string stacked(size_t i, size_t count, const Figure &figure, double right) {
    constexpr double below = 54, above = 10, gap = 14, left = 88; // px
    const double width = kFigureWidth, height = figure.height, plots = static_cast<double>(count);
    const double each = (height - below - above - gap * (plots - 1)) / plots;
    const double bottom = below + (each + gap) * static_cast<double>(count - 1 - i);
    return printed("set lmargin at screen %.6f\nset rmargin at screen %.6f\n"
                   "set bmargin at screen %.6f\nset tmargin at screen %.6f\n",
                   left / width, 1 - right / width, bottom / height, (bottom + each) / height);
}

std::string data_block(const std::string &name, const std::vector<const Numbers *> &columns) {
    std::string text = "$" + name + " << END_OF_DATA\n";
    for (size_t i = 0; i < columns[0]->size(); i++) {
        for (const Numbers *column : columns)
            text += printed("%.9g ", (*column)[i]);
        text += '\n';
    }
    return text + "END_OF_DATA\n";
}

} // namespace cli
