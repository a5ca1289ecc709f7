#include "report/curves.hpp"

#include <algorithm>
#include <cmath>

#include "report/words.hpp"

namespace cli {

namespace {

constexpr size_t kMostPoints = 1500; // of a curve: more than it has pixels
constexpr double kHeadroom = 1.2;    // for the legend, above peak and level

// One of so many is drawn.
size_t step_of(size_t count, size_t most) {
    return std::max<size_t>(1, (count + most - 1) / most);
}

// The lowest frequency that has a logarithm.
double first_of(const PowerCurve &curve) {
    const double first = curve.frequency.front();
    return first > 0 || curve.frequency.size() < 2 ? first : curve.frequency[1];
}

// The highest of each of many narrow intervals of log frequency: no peak is lost.
void put_envelope(const PowerCurve &curve, Numbers &frequency, Numbers &power) {
    const double first = first_of(curve), last = curve.frequency.back();
    const double width = std::log(last / first) / static_cast<double>(kMostPoints);
    double end = 0;
    for (size_t k = 0; k < curve.frequency.size(); k++) {
        const double f = curve.frequency[k], p = curve.power[k];
        if (f < first)
            continue;
        if (frequency.empty() || f >= end) {
            frequency.push_back(f);
            power.push_back(p);
            end = f * std::exp(width);
        } else if (p > power.back()) {
            frequency.back() = f;
            power.back() = p;
        }
    }
}

bool is_marked(double value) {
    return std::isfinite(value) && value > 0;
}

// Whether the peak stands in the right half of the figure.
bool is_on_right(const PowerCurve &curve) {
    return is_marked(curve.peak_frequency) &&
           curve.peak_frequency * curve.peak_frequency > first_of(curve) * curve.frequency.back();
}

// The peak's place, its label and width: what is written stands on the side that has more room.
std::string peak_marks(const PowerCurve &curve, double top, bool on_right) {
    if (!is_marked(curve.peak_frequency))
        return "";
    const double peak = curve.peak_frequency;
    const char *side = on_right ? "right offset -1.2" : "left offset 1.2";
    std::string text = printed("set label 1 at first %.10g,%.10g point pt 11 ps 0.9 lc rgb '#222222' offset 0,0.4\n"
                               "set label 2 ",
                               peak, top) +
                       gnuplot_text(curve.peak_label) +
                       printed(" at first %.10g,%.10g %s,0.1 front boxed noenhanced\n", peak, top, side);
    const double low = std::max(peak - curve.fwhm / 2, first_of(curve));
    const double high = std::min(peak + curve.fwhm / 2, curve.frequency.back());
    const bool has_room = on_right ? low > first_of(curve) : high < curve.frequency.back();
    if (!is_marked(curve.fwhm) || !has_room)
        return text;
    return text +
           printed("set arrow 1 from first %.10g,%.10g to first %.10g,%.10g heads size screen 0.006,60 lw 1.4 lc rgb "
                   "'#222222' front\nset label 3 'FWHM' at first %.10g,%.10g %s,0 front boxed\n",
                   low, top / 2, high, top / 2, on_right ? low : high, top / 2, side);
}

// Places of labels: 1, 2, 5 of every decade, and even steps where those are few.
Numbers tick_places(double first, double last) {
    constexpr size_t fewest = 3;
    Numbers places;
    const int lowest = static_cast<int>(std::floor(std::log10(first)));
    const int highest = static_cast<int>(std::floor(std::log10(last)));
    for (int exponent = lowest; exponent <= highest; exponent++)
        for (const double digit : {1, 2, 5}) {
            const double place = digit * std::pow(10, exponent);
            if (place >= first && place <= last)
                places.push_back(place);
        }
    if (places.size() >= fewest)
        return places;
    places.clear();
    const double quarter = (last - first) / 4, unit = std::pow(10, std::floor(std::log10(quarter)));
    const double step = unit * (quarter >= 5 * unit ? 5 : quarter >= 2 * unit ? 2 : 1);
    const double start = std::ceil(first / step - 1e-6), count = std::floor(last / step + 1e-6) - start;
    for (int i = 0; i <= static_cast<int>(count); i++)
        places.push_back((start + i) * step);
    return places;
}

// gnuplot's own would be none within a decade.
std::string ticks(const PowerCurve &curve) {
    constexpr double most = 1e6; // from last to first; beyond, gnuplot's own
    const double first = first_of(curve), last = curve.frequency.back();
    if (last > most * first)
        return "";
    std::string text;
    for (const double place : tick_places(first, last))
        text += printed("%s%.10g", text.empty() ? "set xtics (" : ", ", place);
    return text + ")\n";
}

std::string curve_script(const PowerCurve &curve, size_t i, size_t count, const std::string &unit,
                         const Figure &figure) {
    Numbers frequency, power;
    put_envelope(curve, frequency, power);
    const double top = std::max(1e-300, *std::max_element(power.begin(), power.end()));
    const double height = kHeadroom * std::max(top, is_marked(curve.level) ? curve.level : 0);
    const std::string block = "power" + std::to_string(i);
    std::string text = data_block(block, {&frequency, &power}) + stacked(i, count, figure);
    text +=
        printed("set xrange [%.10g:%.10g]\nset yrange [0:%.10g]\n", first_of(curve), curve.frequency.back(), height);
    text += i + 1 == count ? "set xlabel " + gnuplot_text("frequency, " + unit) + "\nset format x '%g'\n"
                           : "unset xlabel\nset format x ''\n";
    const bool on_right = is_on_right(curve);
    text += printed(
        "set ylabel 'power (no unit)'\nset key horizontal top %s Left reverse samplen 2\nunset arrow\nunset label\n",
        on_right ? "left" : "right");
    std::string plots =
        printed("plot $%s using 1:2 with lines lw 1.2 lc rgb '%s' title ", block.c_str(), line_colour(i)) +
        gnuplot_text(curve.name);
    if (is_marked(curve.level))
        plots += printed(", %.10g with lines lw 1.2 dt 2 lc rgb '#222222' title 'FAP 0.001'", curve.level);
    return text + peak_marks(curve, top, on_right) + plots + "\n";
}

} // namespace

Numbers thinned(const Numbers &values, size_t most) {
    const size_t step = step_of(values.size(), most);
    Numbers kept;
    for (size_t i = 0; i < values.size(); i += step)
        kept.push_back(values[i]);
    return kept;
}

std::string thinning_remark(size_t count, size_t most) {
    return count > most ? printed(" Of %zu frames one of %zu is drawn.", count, step_of(count, most)) : "";
}

TimeAxis time_axis(const Numbers &t, double period, double least) {
    constexpr double most = 16;    // periods
    constexpr double early = 1e-9; // of a period: by rounding none falls short of a whole number of periods
    const auto [first, last] = std::minmax_element(t.begin(), t.end());
    const double start = *first, cycles = (*last - start) / period;
    if (!(period > 0 && (cycles > most || static_cast<double>(t.size()) < least * cycles)))
        return {t, start, *last, false};
    TimeAxis axis = {t, 0, period, true};
    for (double &x : axis.x)
        x = std::fmod(x - start + early * period, period);
    return axis;
}

Means means_of(const TimeAxis &axis, const Numbers &y, size_t count) {
    const double width = (axis.last - axis.first) / static_cast<double>(count);
    Numbers places(count), sums(count), numbers(count);
    for (size_t i = 0; i < y.size(); i++) {
        const size_t at = width > 0 ? std::min(static_cast<size_t>((axis.x[i] - axis.first) / width), count - 1) : 0;
        places[at] += axis.x[i];
        sums[at] += y[i];
        numbers[at] += 1;
    }
    Means means;
    for (size_t i = 0; i < count; i++)
        if (numbers[i] > 0) {
            means.x.push_back(places[i] / numbers[i]);
            means.y.push_back(sums[i] / numbers[i]);
        }
    return means;
}

void add_power_figure(const std::string &name, const std::string &caption, const std::string &unit,
                      const std::vector<PowerCurve> &curves, Page &page) {
    if (!(first_of(curves[0]) > 0 && curves[0].frequency.back() > first_of(curves[0]))) {
        page.add_text("No figure of the periodogram: its grid has no two frequencies above 0.");
        return;
    }
    Figure figure = {name, caption, curves.size() > 1 ? 480 : 320, "", {}};
    figure.script =
        "set logscale x\n" + ticks(curves[0]) + "set style textbox opaque noborder margins 0.2,0.2\nset multiplot\n";
    for (size_t i = 0; i < curves.size(); i++)
        figure.script += curve_script(curves[i], i, curves.size(), unit, figure);
    figure.script += "unset multiplot\n";
    page.add(std::move(figure));
}

} // namespace cli
