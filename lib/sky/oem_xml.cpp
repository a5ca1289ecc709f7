// Method: the elements of the XML have the names of the keywords of the key-value notation, so that they are written as
// such lines, which the one reader of messages checks. Only this notation is stated here: the structure, the elements
// of a state, and its units. Reference: CCSDS 505.0-B, XML Specification for Navigation Data Messages.
#include "sky/oem_xml.hpp"

#include <algorithm>
#include <array>
#include <iterator>

#include "backend/xml.hpp"
#include "base/error.hpp"

namespace toliman::sky {

namespace {

using ingest::TextLines;

struct Number {
    const char *name, *unit;
};
constexpr Number kState[] = {{"X", "km"},           {"Y", "km"},           {"Z", "km"},
                             {"X_DOT", "km/s"},     {"Y_DOT", "km/s"},     {"Z_DOT", "km/s"},
                             {"X_DDOT", "km/s**2"}, {"Y_DDOT", "km/s**2"}, {"Z_DDOT", "km/s**2"}};
constexpr size_t kNumbers = std::size(kState), kWithoutAcceleration = 6;
constexpr const char *kContainers[] = {"ndm", "oem", "header", "body", "segment", "metadata", "data"};

class Translator {
  public:
    explicit Translator(const char *path) : path_(path) {}

    void begin(const xml::Element &element) {
        const std::string &name = element.name;
        path_of_elements_.push_back(name);
        if (is_covariance_ || name == "COMMENT")
            return;
        if (path_of_elements_.size() == 1 && name != "oem" && name != "ndm")
            refuse(element, "must be an Orbit Ephemeris Message, <oem>");
        if (name == "oem") {
            if (std::exchange(has_message_, true))
                refuse(element, "a second message: must be one");
            write("CCSDS_OEM_VERS = " + element.attribute("version"), element.line);
        } else if (name == "metadata") {
            write("META_START", element.line);
        } else if (name == "stateVector") {
            state_ = {};
        } else if (name == "covarianceMatrix") {
            is_covariance_ = true;
        } else if (!is_container(name) && !is_value()) {
            refuse(element, "unknown element");
        }
    }

    void end(const xml::Element &element) {
        const std::string name = element.name;
        path_of_elements_.pop_back();
        if (name == "covarianceMatrix")
            is_covariance_ = false;
        if (is_covariance_ || name == "covarianceMatrix" || name == "COMMENT" || is_container(name)) {
            if (name == "metadata")
                write("META_STOP", element.line);
            return;
        }
        if (name == "stateVector")
            write_state(element);
        else if (path_of_elements_.back() == "stateVector")
            add_to_state(element, text_of(element));
        else
            write(name + " = " + text_of(element), element.line);
    }

    TextLines lines() && { return {path_, text_, std::move(numbers_)}; }

  private:
    static bool is_container(const std::string &name) {
        return std::find(std::begin(kContainers), std::end(kContainers), name) != std::end(kContainers);
    }
    // Whether the current element is a keyword, or a part of a state.
    bool is_value() const {
        const std::string &parent = path_of_elements_.size() > 1 ? path_of_elements_.end()[-2] : "";
        return parent == "header" || parent == "metadata" || parent == "stateVector";
    }

    [[noreturn]] void refuse(const xml::Element &element, const char *why) const {
        fail(Status::format, "{%s}:%d: <%.60s>: %s", path_, element.line, element.name.c_str(), why);
    }

    // On one line.
    static std::string text_of(const xml::Element &element) {
        std::string text(TextLines::trimmed(element.text));
        std::replace_if(
            text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
        return text;
    }

    void write(const std::string &line, int number) {
        text_ += line + "\n";
        numbers_.push_back(number);
    }

    void add_to_state(const xml::Element &element, const std::string &text) {
        if (text.empty() || text.find(' ') != std::string::npos)
            refuse(element, "must be one time or number");
        if (element.name == "EPOCH") {
            state_[kNumbers] = text;
            return;
        }
        const auto *const number = std::find_if(std::begin(kState), std::end(kState),
                                                [&](const Number &known) { return known.name == element.name; });
        if (number == std::end(kState))
            refuse(element, "unknown element of a state");
        const std::string unit = element.attribute("units");
        if (!unit.empty() && unit != number->unit)
            fail(Status::format, "{%s}:%d: <%s units=\"%.20s\">: must be %s", path_, element.line, number->name,
                 unit.c_str(), number->unit);
        std::string &value = state_[static_cast<size_t>(number - kState)];
        if (!value.empty())
            refuse(element, "is there twice in a state");
        value = text;
    }

    void write_state(const xml::Element &element) {
        std::string line = state_[kNumbers];
        const bool has_acceleration = !state_[kWithoutAcceleration].empty();
        for (size_t i = 0; i < (has_acceleration ? kNumbers : kWithoutAcceleration); i++) {
            if (state_[i].empty() || line.empty())
                fail(Status::format, "{%s}:%d: <stateVector>: %s is missing", path_, element.line,
                     line.empty() ? "EPOCH" : kState[i].name);
            line += " " + state_[i];
        }
        write(line, element.line);
    }

    const char *path_;
    std::vector<std::string> path_of_elements_;   // from the root to the current one
    std::array<std::string, kNumbers + 1> state_; // numbers and time
    bool has_message_ = false, is_covariance_ = false;
    std::string text_;
    std::vector<int> numbers_;
};

} // namespace

ingest::TextLines key_values_of_xml(const char *path, std::string_view text) {
    Translator translator(path);
    xml::parse(path, text,
               {[&](const xml::Element &element) { translator.begin(element); },
                [&](const xml::Element &element) { translator.end(element); }});
    return std::move(translator).lines();
}

} // namespace toliman::sky
