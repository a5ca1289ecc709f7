// Results of a calibration in its journal, with a right checksum and key: one that does not fit its type is computed
// again. The first byte selects the type.
#include <filesystem>
// promises: parsers-are-safe, other-journals-are-refused

#include "calibrate/map.hpp"
#include "calibrate/response.hpp"
#include "calibrate/solve.hpp"
#include "fuzz.hpp"
#include "journal_file.hpp"
#include "optics/propagate.hpp"

using namespace fuzz;
namespace calibrate = toliman::calibrate;

namespace {

template <class Result> void check(const Bytes &bytes) {
    write_journal<Result>(bytes);
    const bool recalled = recall<Result>();
    fuzz::accepted += recalled;
    require(journal_record().bytes == (recalled ? bytes : empty_record<Result>().bytes), "the journal has other bytes");
}

template <class... Results> struct Types {
    static void check_one(size_t which, const Bytes &bytes) {
        size_t at = 0;
        ((which % sizeof...(Results) == at++ ? check<Results>(bytes) : void()), ...);
    }
    static std::vector<Bytes> seeds() {
        std::vector<Bytes> all;
        uint8_t at = 0;
        for (const Bytes &bytes : {empty_record<Results>().bytes...}) {
            all.push_back(bytes);
            all.back().insert(all.back().begin(), at++);
        }
        return all;
    }
};
using AllTypes = Types<calibrate::OwnOfFrames, calibrate::Linearisation, calibrate::Step, calibrate::MapStep,
                       calibrate::ResponseStep, std::vector<calibrate::Block>, std::vector<toliman::BadPixels>,
                       toliman::Buffer<double>>;

} // namespace

std::vector<Bytes> fuzz::seeds() {
    return AllTypes::seeds();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size == 0)
        return 0;
    AllTypes::check_one(data[0], Bytes(data + 1, data + size));
    std::filesystem::remove(journal_path());
    return 0;
}
