// Where keys stand in a hash table. They come from the wire and from files: whoever made them must not know which of
// them share a place, or a table of his would take its square in time. No result depends on it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <random>

namespace toliman::track {

class Scatter {
  public:
    Scatter() {
        std::random_device random;
        secret_ = static_cast<uint64_t>(random()) << 32 | random();
    }
    // One of so many places.
    size_t place(uint64_t key, size_t places) const noexcept {
        __extension__ using Product = unsigned __int128;
        return static_cast<size_t>(static_cast<Product>(spread(key ^ secret_)) * places >> 64);
    }

  private:
    // The finaliser of MurmurHash3: every bit of the key turns half of the others.
    static uint64_t spread(uint64_t key) noexcept {
        key = (key ^ key >> 33) * 0xff51afd7ed558ccdu;
        key = (key ^ key >> 33) * 0xc4ceb9fe1a85ec53u;
        return key ^ key >> 33;
    }
    uint64_t secret_;
};

} // namespace toliman::track
