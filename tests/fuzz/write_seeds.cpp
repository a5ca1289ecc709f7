// With FUZZ_SEEDS=FOLDER a target writes its seeds to the folder and exits, so that libFuzzer can start with them.
#include <fstream>

#include "fuzz.hpp"

extern "C" int LLVMFuzzerInitialize(int *, char ***) {
    const char *folder = std::getenv("FUZZ_SEEDS");
    if (folder == nullptr)
        return 0;
    const std::vector<fuzz::Bytes> seeds = fuzz::seeds();
    for (size_t i = 0; i < seeds.size(); i++) {
        std::ofstream file(std::string(folder) + "/seed-" + std::to_string(i), std::ios::binary);
        file.write(reinterpret_cast<const char *>(seeds[i].data()), static_cast<std::streamsize>(seeds[i].size()));
        if (!file.flush())
            std::abort();
    }
    std::exit(0);
}
