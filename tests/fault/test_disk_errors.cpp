// Every call of the disk fails once: the error is told, nothing more is acknowledged upon a ledger that may be torn,
// and what was acknowledged is there when the folder is opened anew, and after a power cut.
#include <cstdio>

#include "arrivals.hpp"

using namespace fault;

namespace {

constexpr size_t kArrivals = 40, kGroup = 4;
int sticky = 0;

struct Told {
    uint64_t acknowledged = 0;
    bool error = false, went_on = false;
};

Told run_with_failure(Disk &disk, const std::vector<Arrival> &arrivals, long call) {
    Told told;
    std::optional<Run> run;
    try {
        run.emplace(std::make_unique<FakeStore>(disk, -1, call), kGroup);
        for (size_t i = 0; i < arrivals.size(); i++) {
            run->push(arrivals[i]);
            if (i % 10 == 9)
                run->tracker->save();
        }
    } catch (const Error &) {
        told.error = true;
    }
    if (!run)
        return told;
    told.acknowledged = run->tracker->committed();
    if (!told.error)
        return told;
    const auto ledger = [&] { return disk.files[disk.names.at(track::LedgerFile::kName)].now.size(); };
    const size_t size = ledger();
    try { // frames that surely need lines
        for (int64_t id = 1000; id < 1010; id++) {
            Arrival fresh = arrivals[0];
            fresh.id = id;
            run->push(fresh);
        }
        told.went_on = true;
    } catch (const Error &error) {
        expect(error.status() == Status::write, error.what(), 0);
        expect(ledger() == size && run->tracker->committed() == told.acknowledged, "written to after a failed write",
               0);
    }
    return told;
}

// Returns whether the call was made at all.
bool call_fails(long call, const std::vector<Arrival> &arrivals, const Course &course) {
    const auto number = static_cast<uint64_t>(call);
    std::mt19937_64 random(number);
    Disk disk;
    const Told told = run_with_failure(disk, arrivals, call);
    sticky += told.error && !told.went_on;
    for (int power_cut = 0; power_cut < 2 && !told.went_on; power_cut++) {
        Disk left = power_cut != 0 ? disk.after_power_cut(random) : disk;
        uint64_t lines;
        {
            const Run run(std::make_unique<FakeStore>(left), kGroup);
            lines = run.tracker->lines();
            expect(lines >= told.acknowledged, "an acknowledged line is lost", number);
            expect(holds_its_lines(run, course), "the sums are not those of the lines", number);
        }
        // What the recovery showed is on the disk by now.
        Disk later = left.after_power_cut(random);
        Run run(std::make_unique<FakeStore>(later), kGroup);
        expect(run.tracker->lines() >= lines, "a line that was recovered is lost", number);
        push_the_rest(run, arrivals, course, [](size_t) {});
        expect(run.sums.save() == course.states.back(), "the rest did not come in", number);
    }
    return told.error;
}

} // namespace

int main() {
    std::mt19937_64 random(7);
    const std::vector<Arrival> arrivals = make_arrivals(kArrivals, random);
    const Course course = course_of(arrivals);
    long call = 0;
    try {
        while (call_fails(call, arrivals, course))
            call++;
    } catch (const Error &error) {
        expect(false, error.what(), static_cast<uint64_t>(call));
    }
    std::printf("%ld calls failed, %d of them for good, %d failures\n", call, sticky, failures);
    return failures != 0 || call < 50 || sticky < 20;
}
