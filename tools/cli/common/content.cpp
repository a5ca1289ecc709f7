// Method: a file is identified by its magic bytes, by "schema" in JSON, or, if its first 512 bytes have no control
// characters, as text; a folder by the files in it. Only regular files are opened: reading a pipe would block and
// consume its data. An output file counts as toliman's own by a mark that other programs do not write: CREATOR in FITS,
// a .npy header of 256 bytes (NumPy writes 128), the first line of a CSV file.
#include "common/content.hpp"

#include <cctype>
#include <filesystem>
#include <fstream>

namespace cli {

namespace {

constexpr size_t kHeadSize = 23040; // 8 FITS blocks, which contain CREATOR
constexpr size_t kTextSize = 512;   // bytes that are examined for control characters
constexpr char kBlanks[] = " \t\r\n", kByteOrderMark[] = "\xef\xbb\xbf";

bool begins_with(const std::string &text, std::string_view start) {
    return text.compare(0, start.size(), start) == 0;
}

std::string head_of(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    std::string head(kHeadSize, '\0');
    file.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<size_t>(file.gcount()));
    return head;
}

bool is_text(const std::string &head) {
    const std::string start = head.substr(0, kTextSize);
    return std::none_of(start.begin(), start.end(),
                        [](unsigned char byte) { return std::iscntrl(byte) != 0 && std::isspace(byte) == 0; });
}

// The value of "schema" in the text of a JSON object, "" if there is none.
std::string schema_in(const std::string &text) {
    const std::string key = "\"schema\"";
    const size_t at = text.find(key);
    char value[100] = "";
    if (at != std::string::npos)
        std::sscanf(text.c_str() + at + key.size(), " : \"%99[^\"]", value);
    return value;
}

Identity folder_identity(const std::filesystem::path &path) {
    std::error_code error;
    const auto has = [&](const char *name) { return std::filesystem::exists(path / name, error); };
    return {Content::folder,
            std::filesystem::is_empty(path, error) ? "an empty folder"
            : has("ledger.tlml")                   ? "a toliman state folder"
            : has("result.json")                   ? "a folder of toliman run"
            : has("experiment.json")               ? "a folder of toliman.experiment"
                                                   : "a folder",
            ""};
}

Identity text_identity(const std::string &path, const std::string &head) {
    const size_t bom = begins_with(head, kByteOrderMark) ? sizeof kByteOrderMark - 1 : 0;
    const size_t start = head.find_first_not_of(kBlanks, bom);
    if (start == std::string::npos)
        return {Content::empty, "empty", head};
    if (head[start] != '{' && head[start] != '[')
        return {Content::text, ends_with(path, ".csv") ? "a CSV file" : "a text file", head};
    const std::string schema = schema_in(head);
    if (begins_with(schema, "toliman-scene/"))
        return {Content::scene, "a toliman scene", head};
    if (begins_with(schema, "toliman-"))
        return {Content::result, "JSON of schema " + schema, head};
    return {Content::json, "JSON", head};
}

// Whether a FITS header has CREATOR = 'toliman...'.
bool is_own_fits(const std::string &head) {
    constexpr size_t card = 80;
    for (size_t at = 0; at + card <= head.size() && head.compare(at, 8, "END     ") != 0; at += card)
        if (head.compare(at, 18, "CREATOR = 'toliman") == 0)
            return true;
    return false;
}

} // namespace

Identity identify(const std::string &path) {
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(path, error);
    if (std::filesystem::is_directory(status))
        return folder_identity(path);
    if (!std::filesystem::is_regular_file(status)) // reading a pipe would block
        return {};
    const std::string head = head_of(path);
    if (head.empty())
        return std::filesystem::file_size(path, error) == 0 ? Identity{Content::empty, "empty", ""} : Identity{};
    for (const auto &[magic, content, name] :
         {std::tuple("TLMW", Content::weights, "toliman weights"),
          std::tuple("TLMB", Content::bank, "a bank of toliman networks"),
          std::tuple("TLMJ", Content::journal, "the journal of an interrupted computation"),
          std::tuple("TLMA", Content::sums, "a saved state of toliman coadd"),
          std::tuple("TLMP", Content::sums, "a saved state of toliman period"),
          std::tuple("TLML", Content::tracker, "the ledger of a toliman state folder"),
          std::tuple("TLMS", Content::tracker, "the setup of a toliman state folder"),
          std::tuple("TLMC", Content::tracker, "the checkpoint of a toliman state folder"),
          std::tuple("SIMPLE  =", Content::fits, "a FITS file"),
          std::tuple("\x93NUMPY", Content::npy, "a NumPy array")})
        if (begins_with(head, magic))
            return {content, name, head};
    return is_text(head) ? text_identity(path, head) : Identity{Content::unknown, "", head};
}

std::string kind_of(const std::string &path) {
    const std::string name = identify(path).name;
    return name.empty() ? "" : "; it is " + name;
}

std::string installed(const std::string &below_prefix) {
    std::error_code error;
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
    return (program.parent_path().parent_path() / below_prefix).string();
}

std::string shipped_scenes() {
    return installed("share/toliman/scenes");
}

void need(const std::string &path, const std::string &wanted, std::initializer_list<Content> kinds) {
    const Identity file = identify(path);
    if (std::find(kinds.begin(), kinds.end(), file.content) != kinds.end())
        return;
    if (file.content == Content::empty)
        malformed(path, "is empty");
    if (file.content != Content::unknown)
        malformed(path, "is " + file.name + ", not " + wanted);
    std::error_code error;
    const bool is_name = !path.empty() && path.find('/') == std::string::npos;
    if (is_name && std::filesystem::symlink_status(path, error).type() == std::filesystem::file_type::not_found &&
        std::filesystem::exists(shipped_scenes() + "/" + path, error))
        malformed(path, "No such file; the shipped scene of this name is not " + wanted);
}

bool is_own(const Identity &file) {
    switch (file.content) {
    case Content::weights:
    case Content::bank:
    case Content::journal:
    case Content::sums:
    case Content::result:
        return true;
    case Content::fits:
        return is_own_fits(file.head);
    case Content::npy:
        return file.head.size() >= kNpyHeaderSize && begins_with(file.head, kNpyMark);
    case Content::text:
        for (const char *mark :
             {kSeriesMark, kPeriodogramMark, kStatePeriodogramMark, kPeriodSeriesMark, kPeriodPowerMark,
              kPlanetSeriesMark, kPlanetLimitsMark, kPlanetMapMark, kTrainingMark, kEpochsMark})
            if (begins_with(file.head, mark))
                return true;
        return false;
    default:
        return false;
    }
}

} // namespace cli
