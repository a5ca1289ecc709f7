// What files and folders are, by their first bytes, their suffix or the files in them.
#pragma once
#include <string>

namespace cli {

enum class Content { unknown, empty, folder, weights, sums, tracker, fits, npy, scene, result, json, text };

struct Identity {
    Content content = Content::unknown; // also of what is not there or cannot be read
    std::string name;                   // "toliman weights", "a FITS file"; "" of what is unknown
    std::string head;                   // the first bytes of a file
};

Identity identify(const std::string &path);
// What a message adds about a file that it refuses: "; it is toliman weights", "" of what is unknown.
std::string kind_remark(const std::string &path);

// Failures that name what a path is, where that is known and something else was wanted. What is unknown is left to its
// reader.
void need_scene(const std::string &path);
void need_weights(const std::string &path);
void need_sums(const std::string &path);
void need_series(const std::string &path); // or sums, of which its reader says how to give them

// share/toliman/scenes beside the folder of the program, wherever both were moved.
std::string shipped_scenes();

// Whether the content shows that this program wrote it: a mark of its format, see formats.md. Of scenes nothing
// does.
bool is_own(const Identity &file);

// First bytes of text files that this program writes; of experiment.md words in its first lines.
inline constexpr char kSeriesMark[] = "# separation series: t in days, the rest in pixels\n";
inline constexpr char kPeriodogramMark[] =
    "# Lomb-Scargle power of the latents and of the template's values: frequency in 1/day\n";
inline constexpr char kTrainingMark[] = "# loss after each step of training\n";
inline constexpr char kTrialsMark[] =
    "# a method on a series of frames: amplitude_px 0 is without signal; the rest in pixels and days\n";
inline constexpr char kExperimentMark[] = " Medians over the seeds; found: log10 FAP ";
inline constexpr char kPageMark[] = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
                                    "<meta name=\"generator\" content=\"toliman report\">\n";

// Bytes of the header of a .npy file that this program writes: NumPy's own takes 128 for such arrays.
inline constexpr size_t kNpyHeaderSize = 256;

} // namespace cli
