// Power cuts at random calls of the disk, in runs and in recoveries: what was acknowledged is there, what is there is
// what a run of that many lines holds, and the rest can come again. As many as TOLIMAN_POWER_CUTS says.
#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "arrivals.hpp"

using namespace fault;

namespace {

constexpr size_t kArrivals = 60;

struct Story {
    std::vector<Arrival> arrivals;
    Course course;
    size_t group;
    track::Sync sync;
};

struct Acknowledged {
    uint64_t lines = 0;
    int64_t repeats = 0;
};

// Pushes and saves until the power goes; adds what is acknowledged.
void run_until_power_cut(Disk &disk, const Story &story, long cut_at, std::mt19937_64 &random,
                         Acknowledged &acknowledged) {
    const auto acknowledge = [&](const Run &run) {
        acknowledged.lines = std::max(acknowledged.lines, run.tracker->committed());
    };
    try {
        Run run(std::make_unique<FakeStore>(disk, cut_at), story.group, story.sync);
        const bool synced = story.sync != track::Sync::none;
        acknowledge(run);
        push_the_rest(run, story.arrivals, story.course, [&](size_t) {
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

void one_story(uint64_t seed) {
    std::mt19937_64 random(seed);
    const std::vector<Arrival> arrivals = make_arrivals(kArrivals, random);
    const auto sync = static_cast<track::Sync>(random() % 3);
    const Story story = {arrivals, course_of(arrivals), 1 + random() % 12, sync};
    Disk disk;
    Acknowledged acknowledged;
    for (int cut = 0; cut < 4; cut++) { // mostly every other one meets a recovery
        const long at = static_cast<long>(random() % (cut % 2 == 0 ? 150 : 12));
        run_until_power_cut(disk, story, at, random, acknowledged);
        disk = disk.after_power_cut(random);
        Disk copy = disk;
        const Run run(std::make_unique<FakeStore>(copy), story.group, sync);
        expect(run.tracker->lines() >= acknowledged.lines, "an acknowledged line is lost", seed);
        expect(run.tracker->counts().repeated >= acknowledged.repeats, "repeats that were saved are lost", seed);
        expect(holds_its_lines(run, story.course), "the sums are not those of the lines", seed);
    }
    Run run(std::make_unique<FakeStore>(disk), story.group, sync);
    push_the_rest(run, arrivals, story.course, [](size_t) {});
    expect(run.sums.save() == story.course.states.back(), "the rest did not come in", seed);
    run.tracker->save();
    disk = disk.after_power_cut(random);
    const Run last(std::make_unique<FakeStore>(disk), story.group, sync);
    expect(last.sums.save() == story.course.states.back(), "what was saved is not there", seed);
}

// The power goes at each call that begins a folder: it is begun anew, or goes on.
void cut_the_beginning(uint64_t seed) {
    std::mt19937_64 random(seed);
    const std::vector<Arrival> arrivals = make_arrivals(10, random);
    const Story story = {arrivals, course_of(arrivals), 4, track::Sync::group};
    for (long at = 0; at < 40; at++) {
        Disk disk;
        Acknowledged acknowledged;
        run_until_power_cut(disk, story, at, random, acknowledged);
        disk = disk.after_power_cut(random);
        Run run(std::make_unique<FakeStore>(disk), story.group);
        expect(run.tracker->lines() >= acknowledged.lines, "an acknowledged line of a new folder is lost", seed);
        push_the_rest(run, arrivals, story.course, [](size_t) {});
        expect(run.sums.save() == story.course.states.back(), "a folder that was begun does not go on", seed);
    }
}

} // namespace

int main() {
    const char *const given = std::getenv("TOLIMAN_POWER_CUTS");
    const uint64_t stories = (given != nullptr ? std::strtoull(given, nullptr, 10) : 2000) / 4;
    for (uint64_t seed = 0; seed < stories; seed++)
        try {
            one_story(seed);
            if (seed < 50)
                cut_the_beginning(seed);
        } catch (const Error &error) {
            expect(false, error.what(), seed);
        }
    std::printf("%llu power cuts, %d failures\n", static_cast<unsigned long long>(4 * stories), failures);
    return failures != 0;
}
