// Little-endian byte streams, the only way numbers reach or leave a file format.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "base/error.hpp"

namespace toliman {

class ByteWriter {
  public:
    void u8(uint8_t value) { bytes_.push_back(value); }
    void u16(uint16_t value) { put(value, 2); }
    void u32(uint32_t value) { put(value, 4); }
    void u64(uint64_t value) { put(value, 8); }
    void i64(int64_t value) { put(static_cast<uint64_t>(value), 8); }
    void f32(float value) {
        uint32_t bits;
        std::memcpy(&bits, &value, sizeof bits);
        u32(bits);
    }
    void f64(double value) {
        uint64_t bits;
        std::memcpy(&bits, &value, sizeof bits);
        u64(bits);
    }
    void raw(const void *data, size_t size) {
        const auto *first = static_cast<const uint8_t *>(data);
        bytes_.insert(bytes_.end(), first, first + size);
    }
    const std::vector<uint8_t> &bytes() const noexcept { return bytes_; }
    std::vector<uint8_t> take() noexcept { return std::move(bytes_); }

  private:
    void put(uint64_t value, int count) {
        for (int i = 0; i < count; i++)
            bytes_.push_back(static_cast<uint8_t>(value >> (8 * i)));
    }
    std::vector<uint8_t> bytes_;
};

// Reads within bounds; running out is a format error that names the file kind given at construction.
class ByteReader {
  public:
    ByteReader(const void *data, size_t size, const char *kind) noexcept
        : next_(static_cast<const uint8_t *>(data)), left_(size), kind_(kind) {}
    uint8_t u8() { return static_cast<uint8_t>(get(1)); }
    uint16_t u16() { return static_cast<uint16_t>(get(2)); }
    uint32_t u32() { return static_cast<uint32_t>(get(4)); }
    uint64_t u64() { return get(8); }
    int64_t i64() { return static_cast<int64_t>(get(8)); }
    float f32() {
        const uint32_t bits = u32();
        float value;
        std::memcpy(&value, &bits, sizeof value);
        return value;
    }
    double f64() {
        const uint64_t bits = u64();
        double value;
        std::memcpy(&value, &bits, sizeof value);
        return value;
    }
    const uint8_t *raw(size_t size) {
        need(size);
        const uint8_t *data = next_;
        next_ += size;
        left_ -= size;
        return data;
    }
    size_t left() const noexcept { return left_; }

  private:
    void need(size_t size) const {
        if (size > left_)
            fail(Status::format, "%s: truncated: %zu more bytes are needed, %zu are left", kind_, size, left_);
    }
    uint64_t get(size_t count) {
        const uint8_t *data = raw(count);
        uint64_t value = 0;
        for (size_t i = 0; i < count; i++)
            value |= static_cast<uint64_t>(data[i]) << (8 * i);
        return value;
    }
    const uint8_t *next_;
    size_t left_;
    const char *kind_;
};

} // namespace toliman
