// Cuts the power at random calls of the disk, during runs and recoveries. What was acknowledged must be there; the
// state must be that of a run with as many records; and the remaining frames can be pushed again. TOLIMAN_POWER_CUTS
// sets the number of cuts.
#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "arrivals.hpp"

using namespace fault;

namespace {

constexpr size_t kArrivals = 60;

struct Scenario {
    std::vector<Arrival> arrivals;
    Reference reference;
    size_t group;
    track::Sync sync;
};

struct Acknowledged {
    uint64_t records = 0;
    int64_t repeats = 0;
};

// Pushes and saves until the power cut; records what was acknowledged.
void run_until_power_cut(Disk &disk, const Scenario &scenario, long cut_at, std::mt19937_64 &random,
                         Acknowledged &acknowledged) {
    const auto acknowledge = [&](const Run &run) {
        acknowledged.records = std::max(acknowledged.records, run.tracker->committed());
    };
    try {
        Run run(std::make_unique<FakeStore>(disk, cut_at), scenario.group, scenario.sync);
        const bool synced = scenario.sync != track::Sync::none;
        acknowledge(run);
        push_remaining(run, scenario.arrivals, scenario.reference, [&](size_t) {
            if (synced)
                acknowledge(run);
            if (random() % 20 != 0)
                return;
            run.tracker->save();
            acknowledge(run);
            acknowledged.repeats = run.tracker->counts().repeated;
        });
    } catch (const PowerCut &) {
    }
}

void run_scenario(uint64_t seed) {
    std::mt19937_64 random(seed);
    const std::vector<Arrival> arrivals = make_arrivals(kArrivals, random);
    const auto sync = static_cast<track::Sync>(random() % 3);
    const Scenario scenario = {arrivals, reference_of(arrivals), 1 + random() % 12, sync};
    Disk disk;
    Acknowledged acknowledged;
    for (int cut = 0; cut < 4; cut++) { // most odd cuts hit a recovery
        const long at = static_cast<long>(random() % (cut % 2 == 0 ? 150 : 12));
        run_until_power_cut(disk, scenario, at, random, acknowledged);
        disk = disk.after_power_cut(random);
        Disk copy = disk;
        const Run run(std::make_unique<FakeStore>(copy), scenario.group, sync);
        expect(run.tracker->records() >= acknowledged.records, "an acknowledged record is lost", seed);
        expect(run.tracker->counts().repeated >= acknowledged.repeats, "saved repeats are lost", seed);
        expect(matches_its_records(run, scenario.reference), "the sums differ from those of the records", seed);
    }
    Run run(std::make_unique<FakeStore>(disk), scenario.group, sync);
    push_remaining(run, arrivals, scenario.reference, [](size_t) {});
    expect(run.sums.save() == scenario.reference.states.back(), "the remaining frames were not accepted", seed);
    run.tracker->save();
    disk = disk.after_power_cut(random);
    const Run last(std::make_unique<FakeStore>(disk), scenario.group, sync);
    expect(last.sums.save() == scenario.reference.states.back(), "saved records are lost", seed);
}

// Cuts the power at each call that creates a folder: the folder is created again, or opened.
void cut_during_creation(uint64_t seed) {
    std::mt19937_64 random(seed);
    const std::vector<Arrival> arrivals = make_arrivals(10, random);
    const Scenario scenario = {arrivals, reference_of(arrivals), 4, track::Sync::group};
    for (long at = 0; at < 40; at++) {
        Disk disk;
        Acknowledged acknowledged;
        run_until_power_cut(disk, scenario, at, random, acknowledged);
        disk = disk.after_power_cut(random);
        Run run(std::make_unique<FakeStore>(disk), scenario.group);
        expect(run.tracker->records() >= acknowledged.records, "an acknowledged record of a new folder is lost", seed);
        push_remaining(run, arrivals, scenario.reference, [](size_t) {});
        expect(run.sums.save() == scenario.reference.states.back(), "a partly created folder does not continue", seed);
    }
}

// A plan that reduces to this system; "": that does not reduce.
track::Plan plan_of(const std::string &system) {
    track::Plan plan = make_plan(4, track::Sync::group);
    plan.columns = track::Columns(track::kMeasured, !system.empty());
    if (system.empty())
        return plan;
    plan.reference = {system, 0.5};
    plan.reduce = [system](const track::OnTarget &on_target, track::Reduction &reduction) {
        reduction.factor = 1 + 1e-3 * static_cast<double>(on_target.spans.size());
        reduction.geometric_arcsec = system == "old" ? 4.5 : 4.625;
        return on_target.spans.front().end_ns / 1000 % 5 == 0 ? track::Reason::no_orbit : track::Reason::none;
    };
    return plan;
}

struct State {
    std::string system;
    Bytes sums;
    int64_t received, repeated, unreduced;
    bool operator==(const State &other) const {
        return system == other.system && sums == other.sums && received == other.received &&
               repeated == other.repeated && unreduced == other.unreduced;
    }
};

State state_of(const Run &run) {
    const track::Counts &counts = run.tracker->counts();
    return {run.tracker->plan().reference.system, run.sums.save(), counts.received, counts.repeated, counts.unreduced};
}

// The folder as it is, without a system.
State found_state(Disk &disk) {
    track::StateFolder place = Run::open(std::make_unique<FakeStore>(disk));
    if (!place.setup)
        fail(Status::format, "the setup is lost");
    track::Plan plan = plan_of("");
    plan.reference = place.setup->reference;
    return state_of(Run(std::move(place), std::move(plan)));
}

State rebuilt_state(std::unique_ptr<FakeStore> store, const std::string &system) {
    track::StateFolder place = Run::open(std::move(store));
    place.rebuild = true;
    return state_of(Run(std::move(place), plan_of(system)));
}

Disk filled_disk(const std::string &system, std::mt19937_64 &random) {
    Disk disk;
    Run run(Run::open(std::make_unique<FakeStore>(disk)), plan_of(system));
    for (const Arrival &arrival : make_arrivals(15, random))
        run.push(arrival);
    if (random() % 2 == 0)
        run.tracker->save();
    else
        run.tracker->commit();
    return disk;
}

// Cuts the power at each call of a rebuild that reduces the frames again: the folder is the old or the new one, whole,
// and can be rebuilt.
void cut_during_rebuild(uint64_t seed) {
    std::mt19937_64 random(seed);
    const Disk start = filled_disk(seed % 2 == 0 ? "old" : "", random);
    Disk copy = start, rebuilt = start;
    const State before = found_state(copy), after = rebuilt_state(std::make_unique<FakeStore>(rebuilt), "new");
    expect(before.received == after.received && before.sums != after.sums, "a rebuild changes nothing", seed);
    for (long at = 0, is_cut = 1; is_cut != 0; at++) {
        Disk disk = start;
        try {
            rebuilt_state(std::make_unique<FakeStore>(disk, at), "new");
            is_cut = 0;
        } catch (const PowerCut &) {
        }
        disk = disk.after_power_cut(random);
        const State found = found_state(disk);
        expect(found == after || (is_cut != 0 && found == before), "a mixture of two references", seed);
        expect(rebuilt_state(std::make_unique<FakeStore>(disk), "new") == after, "cannot be rebuilt again", seed);
        disk = disk.after_power_cut(random);
        expect(found_state(disk) == after, "a rebuilt folder is lost", seed);
    }
}

} // namespace

// promise: acknowledged-frames-survive-power-cuts
int main() {
    const char *const given = std::getenv("TOLIMAN_POWER_CUTS");
    const uint64_t scenarios = (given != nullptr ? std::strtoull(given, nullptr, 10) : 400) / 4;
    for (uint64_t seed = 0; seed < scenarios; seed++)
        try {
            run_scenario(seed);
            if (seed < 25) {
                cut_during_creation(seed);
                cut_during_rebuild(seed);
            }
        } catch (const Error &error) {
            expect(false, error.what(), seed);
        }
    std::printf("%llu power cuts, %d failures\n", static_cast<unsigned long long>(4 * scenarios), failures);
    return failures != 0;
}
