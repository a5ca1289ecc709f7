#include "common/input.hpp"

#include <filesystem>
#include <sys/stat.h>

#include "common/common.hpp"
#include "common/content.hpp"

namespace cli {

bool exists(const std::string &path) {
    std::error_code error;
    return std::filesystem::exists(path, error);
}

bool is_folder(const std::string &path) {
    std::error_code error;
    return std::filesystem::is_directory(path, error);
}

std::string plain(std::string path) {
    while (path.size() > 1 && path.back() == '/')
        path.pop_back();
    return path;
}

InputFile::InputFile(const std::string &path) : path_(path) {
    struct stat status = {};
    if (::stat(path.c_str(), &status) != 0)
        malformed(path, std::strerror(errno));
    if (!S_ISREG(status.st_mode)) // opening a pipe would block
        malformed(path, "is not a regular file" + kind_of(path));
    file_.reset(std::fopen(path.c_str(), "rb"));
    if (!file_)
        malformed(path, std::strerror(errno));
    size_ = static_cast<size_t>(status.st_size);
}

bool InputFile::read(void *data, size_t size) {
    const bool whole = std::fread(data, 1, size, file_.get()) == size;
    check_input();
    return whole;
}

bool InputFile::ended() {
    const int next = std::getc(file_.get());
    check_input();
    return next == EOF || std::ungetc(next, file_.get()) == EOF;
}

void InputFile::check_input() const {
    if (std::ferror(file_.get()) == 0)
        return;
    const int reason = errno;
    stop_if_asked(); // a signal interrupts reading from standard input
    malformed(path_, std::string("cannot be read: ") + std::strerror(reason));
}

std::string whole_text(const std::string &path) {
    InputFile file(path);
    std::string text(file.size(), '\0');
    if (!file.read(text.data(), text.size()))
        malformed(path, "was truncated while it was read");
    return text;
}

} // namespace cli
