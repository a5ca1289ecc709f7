// Lets every call of the disk fail once. The error must be reported, and nothing more may be acknowledged on a ledger
// that may be torn. What was acknowledged must be there after the folder is reopened, and after a power cut.
#include <cstdio>

#include "arrivals.hpp"

using namespace fault;

namespace {

constexpr size_t kArrivals = 40, kGroup = 4;
int permanent = 0;

struct Observed {
    uint64_t acknowledged = 0;
    bool error = false, continued = false;
};

Observed run_with_failure(Disk &disk, const std::vector<Arrival> &arrivals, long call) {
    Observed observed;
    std::optional<Run> run;
    try {
        run.emplace(std::make_unique<FakeStore>(disk, -1, call), kGroup);
        for (size_t i = 0; i < arrivals.size(); i++) {
            run->push(arrivals[i]);
            if (i % 10 == 9)
                run->tracker->save();
        }
    } catch (const Error &) {
        observed.error = true;
    }
    if (!run)
        return observed;
    observed.acknowledged = run->tracker->committed();
    if (!observed.error)
        return observed;
    const auto ledger = [&] { return disk.files[disk.names.at(track::LedgerFile::kName)].now.size(); };
    const size_t size = ledger();
    try { // frames that need records for sure
        for (int64_t id = 1000; id < 1010; id++) {
            Arrival fresh = arrivals[0];
            fresh.id = id;
            run->push(fresh);
        }
        observed.continued = true;
    } catch (const Error &error) {
        expect(error.status() == Status::write, error.what(), 0);
        expect(ledger() == size && run->tracker->committed() == observed.acknowledged,
               "ledger written after a failed write", 0);
    }
    return observed;
}

// Returns whether the failing call was reached and reported.
bool check_failing_call(long call, const std::vector<Arrival> &arrivals, const Reference &reference) {
    const auto number = static_cast<uint64_t>(call);
    std::mt19937_64 random(number);
    Disk disk;
    const Observed observed = run_with_failure(disk, arrivals, call);
    permanent += observed.error && !observed.continued;
    for (int power_cut = 0; power_cut < 2 && !observed.continued; power_cut++) {
        Disk left = power_cut != 0 ? disk.after_power_cut(random) : disk;
        uint64_t lines;
        {
            const Run run(std::make_unique<FakeStore>(left), kGroup);
            lines = run.tracker->records();
            expect(lines >= observed.acknowledged, "an acknowledged record is lost", number);
            expect(matches_its_records(run, reference), "the sums differ from those of the records", number);
        }
        // What the recovery found must now be on the disk.
        Disk later = left.after_power_cut(random);
        Run run(std::make_unique<FakeStore>(later), kGroup);
        expect(run.tracker->records() >= lines, "a recovered record is lost", number);
        push_remaining(run, arrivals, reference, [](size_t) {});
        expect(run.sums.save() == reference.states.back(), "the remaining frames were not accepted", number);
    }
    return observed.error;
}

} // namespace

// promises: failed-writes-stop-the-tracker, file-failures-are-survived
int main() {
    std::mt19937_64 random(7);
    const std::vector<Arrival> arrivals = make_arrivals(kArrivals, random);
    const Reference reference = reference_of(arrivals);
    long call = 0;
    try {
        while (check_failing_call(call, arrivals, reference))
            call++;
    } catch (const Error &error) {
        expect(false, error.what(), static_cast<uint64_t>(call));
    }
    std::printf("%ld calls failed, %d of them permanently, %d failures\n", call, permanent, failures);
    return failures != 0 || call < 50 || permanent < 20;
}
