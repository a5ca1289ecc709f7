// Results of a calibration in its journal, with a right checksum and key: one that does not fit its type is computed
// again. The first byte selects the type.
#include <filesystem>
#include <optional>
// promises: parsers-are-safe, other-journals-are-refused

#include <unistd.h>

#include "calibrate/map.hpp"
#include "calibrate/memo.hpp"
#include "calibrate/response.hpp"
#include "calibrate/solve.hpp"
#include "fuzz.hpp"
#include "optics/propagate.hpp"

using namespace fuzz;
namespace calibrate = toliman::calibrate;
using toliman::Journal;

namespace {

// In memory, as each input syncs the file.
std::string path() {
    static const std::string made = "/dev/shm/fuzz-journal-" + std::to_string(::getpid());
    return made;
}

Journal opened() {
    return Journal(path(), "FUZZ", {{"another input", 1}});
}

// The only record of the file.
Journal::Record record() {
    Journal journal = opened();
    const Journal::Record *const found = journal.next();
    require(found != nullptr, "no record in the journal");
    return *found;
}

void write(uint64_t key, const Bytes &bytes) {
    std::filesystem::remove(path());
    opened().append(key, bytes, false);
}

// What the journal gives, or a result without content that is computed; true if it was recalled.
template <class Result> bool recall() {
    Journal journal = opened();
    calibrate::Memo memo(journal);
    memo.of<Result>({}, [] { return Result(); });
    return memo.recalled();
}

// The key of a type, which depends on nothing else here, and the bytes of a result without content.
template <class Result> const Journal::Record &empty() {
    static const Journal::Record made = [] {
        std::filesystem::remove(path());
        recall<Result>();
        return record();
    }();
    return made;
}

template <class Result> void check(const Bytes &bytes) {
    write(empty<Result>().key, bytes);
    const bool recalled = recall<Result>();
    require(record().bytes == (recalled ? bytes : empty<Result>().bytes), "the journal has other bytes");
}

template <class... Results> struct Types {
    static void check_one(size_t which, const Bytes &bytes) {
        size_t at = 0;
        ((which % sizeof...(Results) == at++ ? check<Results>(bytes) : void()), ...);
    }
    static std::vector<Bytes> seeds() {
        std::vector<Bytes> all;
        uint8_t at = 0;
        for (const Bytes &bytes : {empty<Results>().bytes...}) {
            all.push_back(bytes);
            all.back().insert(all.back().begin(), at++);
        }
        return all;
    }
};
using AllTypes = Types<calibrate::OwnOfFrames, calibrate::Linearisation, calibrate::Step, calibrate::MapStep,
                       calibrate::ResponseStep, std::vector<calibrate::Block>, std::vector<toliman::BadPixels>,
                       toliman::Buffer<double>, std::vector<toliman::optics::StarImages>>;

} // namespace

std::vector<Bytes> fuzz::seeds() {
    return AllTypes::seeds();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size == 0)
        return 0;
    AllTypes::check_one(data[0], Bytes(data + 1, data + size));
    std::filesystem::remove(path());
    return 0;
}
