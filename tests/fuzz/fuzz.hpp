// Functions shared by the fuzz targets. A target is a file fuzz_NAME.cpp with LLVMFuzzerTestOneInput and, for formats
// with a checksum, a mutator that corrects it: otherwise the code after the checksum would never be reached.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <initializer_list>
#include <string>
#include <vector>

#include "backend/zip.hpp"
#include "base/bytes.hpp"

extern "C" {
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed);
// Provided by libFuzzer or driver.cpp.
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t most);
}

namespace fuzz {

using Bytes = std::vector<uint8_t>;

// Initial inputs other than the text files of corpus/. Defined by every target.
std::vector<Bytes> seeds();

// Inputs so far that were read without an error. A target whose seeds are all refused tests nothing: driver.cpp fails.
inline size_t accepted = 0;

// Reports a finding unless `holds`.
inline void require(bool holds, const char *what) {
    if (holds)
        return;
    std::fprintf(stderr, "finding: %s\n", what);
    std::abort();
}

// Reads numbers from the input; zeros after its end.
class Source {
  public:
    Source(const uint8_t *data, size_t size) : next_(data), left_(size) {}
    uint64_t number(size_t bytes) {
        uint64_t value = 0;
        for (size_t i = 0; i < bytes && left_ > 0; i++, left_--)
            value |= static_cast<uint64_t>(*next_++) << (8 * i);
        return value;
    }
    double real() { return toliman::with_bits<double>(number(8)); }
    Bytes bytes(size_t most) {
        const size_t size = most < left_ ? most : left_;
        Bytes taken(next_, next_ + size);
        next_ += size;
        left_ -= size;
        return taken;
    }
    Bytes rest() { return bytes(left_); }
    size_t left() const noexcept { return left_; }

  private:
    const uint8_t *next_;
    size_t left_;
};

inline void put(Bytes &bytes, size_t at, uint64_t value, int size) {
    toliman::put_number(bytes.data() + at, value, size);
}

// Writes the CRC32 of everything before the last four bytes to them.
inline void seal(Bytes &bytes) {
    if (bytes.size() >= 4)
        put(bytes, bytes.size() - 4, toliman::zip::crc32(bytes.data(), bytes.size() - 4), 4);
}

// Mutates the bytes; at most `most` of them.
inline void mutate(Bytes &bytes, size_t most) {
    const size_t size = bytes.size();
    bytes.resize(size > most ? size : most);
    bytes.resize(LLVMFuzzerMutate(bytes.data(), size, most));
}

inline Bytes bytes_of(const std::string &text) {
    return {text.begin(), text.end()};
}

inline std::vector<Bytes> seeds_of(std::initializer_list<const char *> texts) {
    std::vector<Bytes> seeds;
    for (const char *text : texts)
        seeds.push_back(bytes_of(text));
    return seeds;
}

// A NumPy header padded to 64 bytes, followed by numbers.
inline Bytes npy(const std::string &type, const std::string &shape, size_t size) {
    std::string text = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + shape + "), }";
    text.resize(117, ' ');
    text += '\n';
    Bytes bytes = bytes_of(std::string("\x93NUMPY\1\0v\0", 10) + text); // version 1.0, 118 bytes
    for (size_t i = 0; i < size; i++)
        bytes.push_back(static_cast<uint8_t>(i % 8 == 7 ? 0x40 : i));
    return bytes;
}

inline size_t give(const Bytes &bytes, uint8_t *data, size_t most) {
    const size_t size = bytes.size() < most ? bytes.size() : most;
    if (size > 0)
        std::memcpy(data, bytes.data(), size);
    return size;
}

} // namespace fuzz
