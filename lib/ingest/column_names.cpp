// Method: names are compared in lower case, without unit and punctuation. The names t, y and sigma come first;
// otherwise exactly one column must have one of the usual names, as a wrong column gives a wrong result without an
// error. The standard deviation is looked for by the name of the value: e_rv, rv_err, sig_rv.
#include "ingest/column_names.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <initializer_list>

#include "base/error.hpp"
#include "ingest/fields.hpp"
#include "ingest/unit.hpp"

namespace toliman::ingest {

namespace {

using Words = std::initializer_list<const char *>;

constexpr double kHalf = 2400000.5; // JD - MJD
constexpr double kFirstJd = 2.4e6, kLastJd = 2.5e6, kFewestDays = 1e4, kMostDays = 9e4;

const Words kScaleNames = {"utc", "tai", "tt", "tdb", "gps"}; // in the order of Scale
const Words kValues = {"y",    "value", "values",    "val",        "latent", "rv",   "rvs",     "vr",
                       "vrad", "vel",   "velocity",  "velocities", "radvel", "rvel", "mnvel",   "radialvelocity",
                       "flux", "mag",   "magnitude", "separation", "sep",    "rho",  "latentpx"};
const Words kVelocities = {"rv", "rvs", "vr", "vrad", "vel", "velocity", "radvel", "rvel", "mnvel", "radialvelocity"};
const Words kBefore = {"e", "err", "error", "sig", "sigma", "s", "unc", "std"}; // of the name of the value
const Words kAfter = {"err", "error", "errors", "sig", "sigma", "unc", "uncertainty", "std", "e"};
const Words kSigmas = {"sigma", "sig", "err", "errs", "error", "errors", "e", "uncertainty", "unc", "std", "stddev"};
const Words kInstruments = {"instrument", "inst", "ins", "tel", "telescope", "spectrograph", "source", "facility"};

bool is_one_of(const std::string &word, Words words) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

// Letters and digits in lower case.
std::string plain(std::string_view name) {
    std::string text = lower(name);
    text.erase(
        std::remove_if(text.begin(), text.end(), [](unsigned char c) { return c < 0x80 && std::isalnum(c) == 0; }),
        text.end());
    return text;
}

// Words and numbers of a name of a time.
struct TimeWords {
    std::string day; // "jd" or "mjd"
    bool is_time = false, known = true, julian = false, modified = false;
    double offset = 0;
    std::optional<Scale> scale;

    void add(std::string word);
};

void TimeWords::add(std::string word) {
    size_t index = 0;
    for (const std::string name : kScaleNames) {
        const std::string before = word.substr(0, word.size() - std::min(word.size(), name.size()));
        if (before + name == word && (before.empty() || is_one_of(before, {"jd", "bjd", "hjd", "mjd", "bmjd"}))) {
            scale = static_cast<Scale>(index);
            word = before;
        }
        index++;
    }
    if (is_one_of(word, {"jd", "bjd", "hjd", "jdb", "rjd", "rbjd", "rhjd", "btjd", "bkjd"}))
        day = "jd";
    else if (is_one_of(word, {"mjd", "bmjd", "hmjd"}))
        day = "mjd";
    else if (is_one_of(word,
                       {"t", "time", "times", "date", "dates", "datetime", "epoch", "epochs", "timestamp", "days"}))
        is_time = true;
    else if (word == "julian")
        julian = true;
    else if (word == "modified")
        modified = true;
    else if (!is_one_of(word, {"", "obs", "observation", "mid", "avg", "mean", "center", "centre", "of", "the", "in",
                               "d", "day", "barycentric", "bary", "heliocentric", "helio", "reduced"}))
        known = false;
    if (is_one_of(word, {"rjd", "rbjd", "rhjd", "reduced"}))
        offset = kReducedJd;
    else if (word == "btjd" || word == "bkjd") // of TESS and Kepler
        offset = word == "btjd" ? 2457000 : 2454833;
}

TimeWords time_words(std::string_view name) {
    std::string text = lower(name);
    text.erase(std::remove(text.begin(), text.end(), ','), text.end()); // of 2,450,000
    TimeWords words;
    for (size_t at = 0; at < text.size();) {
        const char *const start = text.data() + at, *const end = text.data() + text.size();
        const auto is_letter = [](char c) { return c >= 'a' && c <= 'z'; };
        const char *stop = std::find_if_not(start, end, is_letter);
        if (stop > start) {
            words.add({start, stop});
        } else if (std::isdigit(static_cast<unsigned char>(*start)) != 0) {
            words.known = words.known && words.offset == 0;
            stop = std::from_chars(start, end, words.offset).ptr;
        } else {
            words.known = words.known && static_cast<unsigned char>(*start) < 0x80;
            stop = start + 1;
        }
        at = static_cast<size_t>(stop - text.data());
    }
    if (words.julian && words.day.empty())
        words.day = words.modified ? "mjd" : "jd";
    return words;
}

std::vector<std::string> bases_of(const std::vector<std::string> &names) {
    std::vector<std::string> bases;
    for (const std::string &name : names)
        bases.push_back(plain(split_unit(name).name));
    return bases;
}

// The only place of those found; kNoPlace for none.
size_t only(const std::vector<size_t> &found, const std::vector<std::string> &names, const char *what) {
    if (found.size() > 1)
        fail(Status::mismatch, "has the columns {%s} and %s, which could both be %s", names[found[0]].c_str(),
             names[found[1]].c_str(), what);
    return found.empty() ? kNoPlace : found[0];
}

template <class Test> std::vector<size_t> places_where(size_t count, Test test) {
    std::vector<size_t> places;
    for (size_t i = 0; i < count; i++)
        if (test(i))
            places.push_back(i);
    return places;
}

size_t named(const std::vector<std::string> &names, const char *name) {
    return only(places_where(names.size(), [&](size_t i) { return split_unit(names[i]).name == name; }), names, name);
}

size_t time_place(const std::vector<std::string> &names, const std::vector<std::string> &bases) {
    if (const size_t t = named(names, "t"); t != kNoPlace)
        return t;
    std::vector<size_t> found = places_where(names.size(), [&](size_t i) { return time_name(names[i]).has_value(); });
    if (found.size() == 2 && is_one_of(bases[found[0]], {"mjd", "jd"}) && is_one_of(bases[found[1]], {"mjd", "jd"}) &&
        bases[found[0]] != bases[found[1]])
        return bases[found[0]] == "mjd" ? found[0] : found[1]; // the same times
    return only(found, names, "t");
}

// The names of the standard deviation of a value.
bool is_sigma_of(const std::string &name, const std::string &value) {
    const auto before = [&](const char *word) { return name == word + value; };
    const auto after = [&](const char *word) { return name == value + word; };
    return std::any_of(kBefore.begin(), kBefore.end(), before) || std::any_of(kAfter.begin(), kAfter.end(), after) ||
           (value == "y" && name == "dy");
}

size_t sigma_place(const std::vector<std::string> &names, const std::vector<std::string> &bases,
                   const std::string &value) {
    std::vector<size_t> found = places_where(names.size(), [&](size_t i) { return is_sigma_of(bases[i], value); });
    const size_t exact = named(names, "sigma");
    if (exact != kNoPlace && value == "y")
        return exact;
    if (exact != kNoPlace)
        found.push_back(exact);
    if (found.empty() && is_one_of(value, kVelocities))
        found = places_where(names.size(), [&](size_t i) {
            const auto is_of = [&](const char *velocity) { return is_sigma_of(bases[i], velocity); };
            return std::any_of(kVelocities.begin(), kVelocities.end(), is_of);
        });
    if (found.empty())
        found = places_where(names.size(), [&](size_t i) { return is_one_of(bases[i], kSigmas); });
    return only(found, names, "sigma");
}

} // namespace

NameAndUnit split_unit(const std::string &name) {
    const std::string text = trimmed(name);
    const size_t close = text.empty() ? std::string::npos : std::string(")]}").find(text.back());
    const size_t open = close == std::string::npos ? close : text.find("([{"[close]);
    if (open == std::string::npos || open == 0)
        return {text, ""};
    return {trimmed(text.substr(0, open)), trimmed(text.substr(open + 1, text.size() - open - 2))};
}

std::optional<TimeName> time_name(std::string_view name) {
    const NameAndUnit parts = split_unit(std::string(name));
    const TimeWords words = time_words(unit_of(parts.unit).quantity == Quantity::time ? parts.name : name);
    if (!words.known || (words.day.empty() && (!words.is_time || words.offset > 0)))
        return std::nullopt;
    TimeName time = {std::nullopt, 0, words.scale};
    if (words.day.empty())
        return time;
    const double offset = words.offset, whole = std::floor(offset);
    const bool is_jd = words.day == "jd";
    const bool suits = is_jd ? offset >= kFirstJd && offset <= kLastJd : offset >= kFewestDays && offset <= kMostDays;
    if (offset != 0 && (!suits || (offset != whole && (!is_jd || offset - whole != 0.5))))
        return std::nullopt;
    time.format = is_jd && offset == whole ? TimeFormat::jd : TimeFormat::mjd;
    time.offset = static_cast<int64_t>(is_jd && offset != whole ? offset - kHalf : offset);
    return time;
}

size_t column_number(const std::string &text) noexcept {
    size_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc() && end == text.data() + text.size() ? number : 0;
}

size_t place_of(const std::string &wanted, const std::vector<std::string> &names) {
    using Form = std::string (*)(const std::string &name);
    const auto compares = [&](Form form) {
        return only(places_where(names.size(), [&](size_t i) { return form(names[i]) == form(wanted); }), names,
                    wanted.c_str());
    };
    const Form same = [](const std::string &name) { return name; };
    const Form base = [](const std::string &name) { return split_unit(name).name; };
    const Form caseless = [](const std::string &name) { return lower(split_unit(name).name); };
    for (const Form form : {same, base, caseless})
        if (const size_t place = compares(form); place != kNoPlace)
            return place;
    const size_t number = column_number(wanted);
    return number >= 1 && number <= names.size() ? number - 1 : kNoPlace;
}

Places usual_places(const std::vector<std::string> &names) {
    const std::vector<std::string> bases = bases_of(names);
    Places places;
    places.t = time_place(names, bases);
    places.y = named(names, "y");
    if (places.y == kNoPlace)
        places.y =
            only(places_where(names.size(), [&](size_t i) { return i != places.t && is_one_of(bases[i], kValues); }),
                 names, "y");
    if (places.y != kNoPlace)
        places.sigma = sigma_place(names, bases, bases[places.y]);
    return places;
}

bool name_a_series(const std::vector<std::string> &names) {
    const std::vector<std::string> bases = bases_of(names);
    return std::any_of(names.begin(), names.end(),
                       [](const std::string &name) { return time_name(name).has_value(); }) &&
           std::any_of(bases.begin(), bases.end(), [](const std::string &base) { return is_one_of(base, kValues); });
}

Places places_of(const std::vector<std::string> &wanted, const std::vector<std::string> &names) {
    if (wanted.empty())
        return usual_places(names);
    Places places = {place_of(wanted[0], names), place_of(wanted[1], names), kNoPlace};
    if (wanted.size() > 2)
        places.sigma = place_of(wanted[2], names);
    return places;
}

std::string likely_sigma(const std::vector<std::string> &names, const Places &used) {
    for (size_t i = 0; i < names.size(); i++) {
        const std::string base = plain(split_unit(names[i]).name);
        const auto contains = [&](const char *word) { return base.find(word) != std::string::npos; };
        const Words words = {"err", "sig", "unc", "noise", "std", "precision"};
        if (i != used.t && i != used.y && std::any_of(words.begin(), words.end(), contains))
            return names[i];
    }
    return "";
}

bool is_instrument(const std::string &name) {
    return is_one_of(plain(name), kInstruments);
}

} // namespace toliman::ingest
