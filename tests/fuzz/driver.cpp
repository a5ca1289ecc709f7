// Runs a target without libFuzzer: its seeds and every file of the given folders, of which one must be accepted, then a
// number of mutants of each (FUZZ_ROUNDS, default 200). The mutants are the same in every run.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "fuzz.hpp"

// NULL if the target does not define a mutator.
#pragma weak LLVMFuzzerCustomMutator

namespace {

constexpr size_t kMost = 1 << 16;

std::mt19937_64 random_numbers;

size_t below(size_t end) {
    return random_numbers() % end;
}

fuzz::Bytes read(const std::filesystem::path &path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

size_t mutant(fuzz::Bytes &bytes, size_t size, unsigned seed) {
    if (LLVMFuzzerCustomMutator != nullptr)
        return LLVMFuzzerCustomMutator(bytes.data(), size, bytes.size(), seed);
    return LLVMFuzzerMutate(bytes.data(), size, bytes.size());
}

void run(const fuzz::Bytes &seed, size_t rounds) {
    random_numbers.seed(seed.size());
    for (unsigned round = 0; round < rounds; round++) {
        fuzz::Bytes bytes = seed;
        bytes.resize(std::max(kMost, seed.size()));
        bytes.resize(mutant(bytes, seed.size(), round));
        LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
    }
}

} // namespace

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t most) {
    constexpr uint8_t kOdd[] = {0, 1, 0x7f, 0x80, 0xff, ' ', '"', '\n'};
    const uint8_t byte = below(2) == 0 ? kOdd[below(sizeof kOdd)] : static_cast<uint8_t>(random_numbers());
    const size_t at = size > 0 ? below(size) : 0;
    switch (below(size > 0 ? 6 : 1)) {
    case 0: // insert a byte
        if (size == most)
            return size;
        std::memmove(data + at + 1, data + at, size - at);
        data[at] = byte;
        return size + 1;
    case 1: // remove a byte
        std::memmove(data + at, data + at + 1, size - at - 1);
        return size - 1;
    case 2: // truncate
        return at;
    case 3: // copy bytes from elsewhere
        std::memmove(data + at, data + below(size), std::min(size - at, below(16)) & (size - at) / 2);
        return size;
    case 4:
        data[at] = static_cast<uint8_t>(data[at] ^ 1 << below(8));
        return size;
    default:
        data[at] = byte;
        return size;
    }
}

int main(int count, char **arguments) {
    const char *asked = std::getenv("FUZZ_ROUNDS");
    const size_t rounds = asked != nullptr ? std::strtoull(asked, nullptr, 10) : 200;
    std::vector<std::filesystem::path> files;
    for (int i = 1; i < count; i++)
        for (const auto &entry : std::filesystem::directory_iterator(arguments[i]))
            files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::vector<fuzz::Bytes> inputs = fuzz::seeds();
    for (const auto &path : files)
        inputs.push_back(read(path));
    for (const fuzz::Bytes &input : inputs)
        LLVMFuzzerTestOneInput(input.data(), input.size());
    fuzz::require(fuzz::accepted > 0, "every seed is refused");
    for (const fuzz::Bytes &input : inputs)
        run(input, rounds);
    std::printf("%zu inputs, %zu mutants of each\n", inputs.size(), rounds);
    return inputs.empty();
}
