// Slots of keys in a hash table, with a random secret. Keys come from the downlink and from files; with a known hash
// function, crafted keys could all collide and take quadratic time. No result depends on the secret.
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
    // Slot of a key in a table of `slots` slots.
    size_t slot(uint64_t key, size_t slots) const noexcept {
        __extension__ using Product = unsigned __int128;
        return static_cast<size_t>(static_cast<Product>(mix(key ^ secret_)) * slots >> 64);
    }

  private:
    // The finaliser of MurmurHash3: each bit of the key flips every bit of the result with a probability of about 1/2.
    static uint64_t mix(uint64_t key) noexcept {
        key = (key ^ key >> 33) * 0xff51afd7ed558ccdu;
        key = (key ^ key >> 33) * 0xc4ceb9fe1a85ec53u;
        return key ^ key >> 33;
    }
    uint64_t secret_;
};

} // namespace toliman::track
