// Identifies files and folders by their first bytes, their suffix or the files in them.
#pragma once
#include <initializer_list>
#include <string_view>

#include "common/common.hpp"

namespace cli {

enum class Content {
    unknown,
    empty,
    folder,
    weights,
    bank,
    journal,
    sums,
    tracker,
    fits,
    npy,
    scene,
    result,
    json,
    text
};

struct Identity {
    Content content = Content::unknown; // also if there is no file or it cannot be read
    std::string name;                   // "toliman weights", "a FITS file"; "" if unknown
    std::string head;                   // the first bytes of a file
};

Identity identify(const std::string &path);
// Suffix for a message that refuses a file: "; it is toliman weights", "" if unknown.
std::string kind_of(const std::string &path);

// Throws Failure if the content of a path is known and is none of `kinds`, which are called `wanted`. Unknown content
// is left to its reader.
void need(const std::string &path, const std::string &wanted, std::initializer_list<Content> kinds);

// The path of an installed file or folder, relative to the prefix of the program: both can be moved together.
std::string installed(const std::string &below_prefix);
// installed("share/toliman/scenes")
std::string shipped_scenes();

// Whether a mark in the content shows that this program wrote it, see formats.md. Scenes have no mark.
bool is_own(const Identity &file);

// First bytes of text files that this program writes.
inline constexpr char kSeriesMark[] = "# separation series: t in days, the rest in pixels\n";
inline constexpr char kPeriodogramMark[] =
    "# Lomb-Scargle power of the latents and of the template's values: frequency in 1/day\n";
inline constexpr char kStatePeriodogramMark[] = "# Lomb-Scargle power of a state folder: frequency per unit of time\n";
inline constexpr char kPeriodSeriesMark[] =
    "# series of toliman period; nuisance: mean and nuisance functions as fitted at the peak\n";
inline constexpr char kPeriodPowerMark[] = "# Lomb-Scargle power of toliman period: frequency per unit of t\n";
inline constexpr char kPlanetSeriesMark[] =
    "# series of toliman planet; residual: of the joint fit; signal_1 ...: of the planets\n";
inline constexpr char kPlanetLimitsMark[] = "# limits of toliman planet, probability 0.95: circular orbits\n";
inline constexpr char kPlanetMapMark[] = "# detection map of toliman planet: detected planets of those injected\n";
inline constexpr char kTrainingMark[] = "# loss after each step of training\n";
inline constexpr char kEpochsMark[] = "# epochs of an unsupervised training; log10_fap: of the latents of frames\n";

// The same of .npy files: version 1.0, and the size of the text that follows in their header of 256 bytes. NumPy writes
// 128 bytes for such arrays.
inline constexpr size_t kNpyHeaderSize = 256;
using std::string_view_literals::operator""sv;
inline constexpr auto kNpyMark = "\x93NUMPY\1\0\xf6\0{'descr': '"sv;

} // namespace cli
