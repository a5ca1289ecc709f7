// Method: the text, one bit 1, zeros and the length in bits fill blocks of 64 bytes. Each block changes the five words
// in 80 rounds. Reference: FIPS 180-4, sections 5.1.1 and 6.1.
#include "base/sha1.hpp"

#include <string>

namespace toliman {

namespace {

constexpr size_t kBlock = 64, kWords = 16, kRounds = 80;

uint32_t rotated(uint32_t word, int bits) noexcept {
    return word << bits | word >> (32 - bits);
}

std::string padded(std::string_view text) {
    std::string bytes(text);
    bytes += '\x80';
    bytes.resize((bytes.size() + 8 + kBlock - 1) / kBlock * kBlock - 8);
    for (int shift = 56; shift >= 0; shift -= 8)
        bytes += static_cast<char>(uint64_t{text.size()} * 8 >> shift & 0xff);
    return bytes;
}

struct Round {
    uint32_t f, constant;
};
Round round_of(size_t round, uint32_t b, uint32_t c, uint32_t d) noexcept {
    if (round < 20)
        return {(b & c) | (~b & d), 0x5a827999};
    if (round < 40)
        return {b ^ c ^ d, 0x6ed9eba1};
    if (round < 60)
        return {(b & c) | (b & d) | (c & d), 0x8f1bbcdc};
    return {b ^ c ^ d, 0xca62c1d6};
}

void add_block(const char *bytes, std::array<uint32_t, 5> &hash) noexcept {
    uint32_t words[kRounds] = {};
    for (size_t i = 0; i < kBlock; i++)
        words[i / 4] = words[i / 4] << 8 | static_cast<uint8_t>(bytes[i]);
    for (size_t i = kWords; i < kRounds; i++)
        words[i] = rotated(words[i - 3] ^ words[i - 8] ^ words[i - 14] ^ words[i - 16], 1);
    auto [a, b, c, d, e] = hash;
    for (size_t i = 0; i < kRounds; i++) {
        const Round round = round_of(i, b, c, d);
        const uint32_t next = rotated(a, 5) + round.f + e + round.constant + words[i];
        e = d;
        d = c;
        c = rotated(b, 30);
        b = a;
        a = next;
    }
    const uint32_t added[] = {a, b, c, d, e};
    for (size_t i = 0; i < hash.size(); i++)
        hash[i] += added[i];
}

} // namespace

std::array<uint32_t, 5> sha1(std::string_view text) {
    std::array<uint32_t, 5> hash = {0x67452301, 0xefcdab89, 0x98badcfe, 0x10325476, 0xc3d2e1f0};
    const std::string bytes = padded(text);
    for (size_t at = 0; at < bytes.size(); at += kBlock)
        add_block(&bytes[at], hash);
    return hash;
}

} // namespace toliman
