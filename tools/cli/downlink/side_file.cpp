#include "downlink/side_file.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <iterator>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "common/json.hpp"

namespace cli {

namespace {

constexpr const char *kKeys[] = {"frame_id",  "timestamp_ns", "host_time", "nframes_dropped",
                                 "roi_label", "n_rows",       "n_cols",    "session_id"};
constexpr int64_t kLargestSide = 65536, kMostDropped = 65535;
constexpr size_t kLongestLine = 4096;
// A line of a frame has more bytes than this. What has far more lines than that allows is no side file, and would take
// much more memory than it has bytes.
constexpr size_t kShortestLine = 120, kMoreLines = 1024;

class BadSideLine {
  public:
    explicit BadSideLine(const std::string &why) : why_(why) {}
    const std::string &why() const noexcept { return why_; }

  private:
    std::string why_;
};

const std::string kNameRule = " must be 1 to 64 of A-Z a-z 0-9 . _ - and not begin with a dot";

bool is_name(const std::string &text) {
    return !text.empty() && text.size() <= 64 && text[0] != '.' &&
           text.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-") ==
               std::string::npos;
}

const cJSON &member(const cJSON *object, const char *key) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
    if (item == nullptr)
        throw BadSideLine(std::string(key) + " is missing");
    return *item;
}

// Where the value of a key begins; a name may be the same word.
size_t place_of(const std::string &line, const std::string &key) {
    constexpr char kSpace[] = " \t";
    for (size_t at = line.find(key); at != std::string::npos; at = line.find(key, at + 1)) {
        const size_t colon = line.find_first_not_of(kSpace, at + key.size());
        if (colon != std::string::npos && line[colon] == ':')
            return line.find_first_not_of(kSpace, colon + 1);
    }
    return std::string::npos;
}

// cJSON's numbers are doubles, a clock has more digits: they are read from the text.
int64_t whole(const cJSON *object, const std::string &line, const char *key, int64_t least, int64_t most) {
    int64_t value = 0;
    const size_t at = place_of(line, '"' + std::string(key) + '"');
    bool good = cJSON_IsNumber(&member(object, key)) != 0 && at != std::string::npos;
    if (good) {
        const auto [end, error] = std::from_chars(line.data() + at, line.data() + line.size(), value);
        good = error == std::errc() && end < line.data() + line.size() && std::strchr(" \t,}", *end) != nullptr &&
               value >= least && value <= most;
    }
    if (!good)
        throw BadSideLine(std::string(key) + " must be a whole number from " + std::to_string(least) + " to " +
                          std::to_string(most));
    return value;
}

std::string name(const cJSON *object, const char *key) {
    const cJSON &item = member(object, key);
    std::string text = cJSON_IsString(&item) != 0 ? item.valuestring : "";
    if (!is_name(text))
        throw BadSideLine(key + kNameRule);
    return text;
}

// Neither others than the eight keys nor one of them twice.
void check_keys(const cJSON *object) {
    for (const cJSON *item = object->child; item != nullptr; item = item->next) {
        const std::string key = item->string;
        if (std::find(std::begin(kKeys), std::end(kKeys), key) == std::end(kKeys))
            throw BadSideLine((is_name(key) ? "the key " + key : "a key of other letters than A-Z a-z 0-9 . _ -") +
                              " is none of the eight of a side file");
        if (&member(object, key.c_str()) != item)
            throw BadSideLine(key + " is there twice");
    }
}

void read_line(const std::string &line, SideLine &read) {
    if (line.size() > kLongestLine)
        throw BadSideLine("is longer than " + std::to_string(kLongestLine) + " bytes");
    const JsonTree tree(line.find('\0') == std::string::npos ? cJSON_ParseWithOpts(line.c_str(), nullptr, 1) : nullptr);
    const cJSON *object = tree.get();
    if (cJSON_IsObject(object) == 0)
        throw BadSideLine("is no JSON object");
    FrameFacts &facts = read.facts;
    facts.session = name(object, "session_id");
    facts.roi = name(object, "roi_label");
    facts.id = whole(object, line, "frame_id", INT64_MIN, INT64_MAX);
    read.named = true;
    facts.camera_ns = whole(object, line, "timestamp_ns", INT64_MIN, INT64_MAX);
    facts.dropped = whole(object, line, "nframes_dropped", 0, kMostDropped);
    facts.rows = static_cast<size_t>(whole(object, line, "n_rows", 1, kLargestSide));
    facts.cols = static_cast<size_t>(whole(object, line, "n_cols", 1, kLargestSide));
    const cJSON &host = member(object, "host_time");
    if (cJSON_IsNumber(&host) == 0)
        throw BadSideLine("host_time must be a number");
    read.host_s = host.valuedouble;
    check_keys(object);
}

} // namespace

void check_name(const std::string &name, const std::string &where) {
    if (!is_name(name))
        malformed(where, "session " + name + kNameRule);
}

SideLine read_side_line(const std::string &line) {
    SideLine read;
    try {
        read_line(line, read);
    } catch (const BadSideLine &bad) {
        read.why = bad.why();
    }
    return read;
}

std::vector<SideLine> read_side_file(const std::string &path, bool growing) {
    const std::string text = whole_text(path);
    const size_t most = kMoreLines + text.size() / kShortestLine;
    std::vector<SideLine> lines;
    for (size_t at = 0; at < text.size();) {
        const size_t newline = text.find('\n', at);
        if (newline == std::string::npos && growing)
            break;
        const size_t end = std::min(newline, text.size());
        if (lines.size() == most)
            malformed(path, "holds more than " + std::to_string(most) + " lines in " + std::to_string(text.size()) +
                                " bytes, a frame takes " + std::to_string(kShortestLine));
        lines.push_back(read_side_line(text.substr(at, end - at)));
        at = end + 1;
    }
    return lines;
}

} // namespace cli
