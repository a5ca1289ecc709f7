// Power cuts at random calls of the disk, in runs and in recoveries: what was acknowledged is there, what is there is
// what a run of that many lines holds, and the rest can come again. As many as TOLIMAN_POWER_CUTS says.
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

// Pushes and saves until the power goes; returns the lines that are acknowledged.
uint64_t run_until_power_cut(Disk &disk, const Story &story, long cut_at, std::mt19937_64 &random) {
    uint64_t acknowledged = 0;
    try {
        Run run(std::make_unique<FakeStore>(disk, cut_at), story.group, story.sync);
        const bool synced = story.sync != track::Sync::none;
        acknowledged = run.tracker->committed();
        push_the_rest(run, story.arrivals, story.course, [&](size_t) {
            acknowledged = synced ? run.tracker->committed() : acknowledged;
            if (random() % 20 != 0)
                return;
            run.tracker->save();
            acknowledged = run.tracker->committed();
        });
    } catch (const PowerCut &) {
    }
    return acknowledged;
}

void one_story(uint64_t seed) {
    std::mt19937_64 random(seed);
    const std::vector<Arrival> arrivals = make_arrivals(kArrivals, random);
    const auto sync = static_cast<track::Sync>(random() % 3);
    const Story story = {arrivals, course_of(arrivals), 1 + random() % 12, sync};
    Disk disk;
    uint64_t acknowledged = 0;
    for (int cut = 0; cut < 4; cut++) { // mostly every other one meets a recovery
        const long at = static_cast<long>(random() % (cut % 2 == 0 ? 150 : 12));
        acknowledged = std::max(acknowledged, run_until_power_cut(disk, story, at, random));
        disk = disk.after_power_cut(random);
        Disk copy = disk;
        const Run run(std::make_unique<FakeStore>(copy), story.group, sync);
        expect(run.tracker->lines() >= acknowledged, "an acknowledged line is lost", seed);
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

} // namespace

int main() {
    const char *const given = std::getenv("TOLIMAN_POWER_CUTS");
    const uint64_t stories = (given != nullptr ? std::strtoull(given, nullptr, 10) : 2000) / 4;
    for (uint64_t seed = 0; seed < stories; seed++)
        try {
            one_story(seed);
        } catch (const Error &error) {
            expect(false, error.what(), seed);
        }
    std::printf("%llu power cuts, %d failures\n", static_cast<unsigned long long>(4 * stories), failures);
    return failures != 0;
}
