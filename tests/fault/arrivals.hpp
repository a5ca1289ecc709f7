// A sequence of small frames with the usual faults of a downlink, and trackers of these frames on a simulated disk.
#pragma once
#include <cstdio>
#include <memory>
#include <optional>
#include <vector>

#include "fake_disk.hpp"
#include "track/tracker.hpp"

namespace fault {

using namespace toliman;

constexpr size_t kSide = 4, kPixels = kSide * kSide;
constexpr size_t kArcs = 12; // intervals of a frame: two records in a ledger that reduces

struct Arrival {
    uint16_t pixels[kPixels];
    int64_t id;
    // Every third frame has intervals.
    track::Frame frame() const {
        static const std::vector<double> arcs = [] {
            std::vector<double> ends(2 * kArcs);
            for (size_t i = 0; i < ends.size(); i++)
                ends[i] = static_cast<double>(i) / 64;
            return ends;
        }();
        const size_t count = id % 3 == 1 ? kArcs : 0;
        return {"pass",     "core", id, id * 1000, 0,           pixels, kSide, kSide, kSide,
                Pixel::u16, 0,      0,  1,         arcs.data(), count,  0,     0};
    }
};

// Some frames are duplicates, some repeat with other bytes, some are damaged, some are outliers.
inline std::vector<Arrival> make_arrivals(size_t count, std::mt19937_64 &random) {
    std::vector<Arrival> arrivals;
    while (arrivals.size() < count) {
        Arrival arrival = {};
        for (uint16_t &pixel : arrival.pixels)
            pixel = static_cast<uint16_t>(1 + random() % 1000);
        arrival.id = static_cast<int64_t>(arrivals.size());
        const uint64_t kind = random() % 10;
        if (!arrivals.empty() && kind < 3) {
            arrival = arrivals[random() % arrivals.size()];
            if (kind < 2)
                arrival.pixels[0] = static_cast<uint16_t>(arrival.pixels[0] ^ 1);
        }
        if (kind == 3)
            arrival.pixels[5] = 60000;
        if (kind == 4)
            arrival.pixels[0] = 4000;
        arrivals.push_back(arrival);
    }
    return arrivals;
}

inline track::Plan make_plan(size_t group, track::Sync sync) {
    track::Plan plan;
    plan.capacity = 500;
    plan.terms.geometry = {kSide, kSide, 0, 0, kSide, kSide, 1, 12, 0};
    plan.terms.sigma = 0.5;
    plan.terms.value_limit = 3;
    plan.terms.estimator = 5;
    plan.group = group;
    plan.sync = sync;
    return plan;
}

// A tracker and its periodogram.
struct Run {
    Run(std::unique_ptr<FakeStore> store, size_t group, track::Sync sync = track::Sync::group)
        : Run(open(std::move(store)), make_plan(group, sync)) {}
    Run(track::StateFolder place, track::Plan plan) : sums(grid()) {
        tracker.emplace(
            std::move(plan),
            [](const double *image, const track::Frame &, int64_t, unsigned, track::Estimated &estimated) {
                estimated.value = (image[0] - image[1] + image[2]) / 1024;
                estimated.further[0] = 9 + estimated.value;
            },
            std::move(place), sums);
    }
    static track::StateFolder open(std::unique_ptr<FakeStore> store) {
        return track::open_state_folder(std::move(store), Access::write, make_plan(1, track::Sync::group).terms);
    }
    static period::Grid grid() {
        period::Grid grid;
        grid.f0 = 0.01;
        grid.df = 0.013;
        grid.nf = 9;
        grid.unit_ns = 1e4;
        return track::for_terms(grid, make_plan(1, track::Sync::group).terms);
    }
    void push(const Arrival &arrival) {
        const track::Frame frame = arrival.frame();
        track::Outcome outcome;
        size_t done;
        tracker->push(&frame, 1, &outcome, done);
    }
    period::Stream sums;
    std::optional<track::Tracker> tracker;
};

// Number of records of frames.
inline uint64_t frame_records(const Run &run) {
    uint64_t lines = 0;
    run.tracker->visit(0, run.tracker->records(), [&](const track::Record &record, const track::Outcome &) {
        lines += record.kind != track::Kind::merged && record.kind != track::Kind::intervals;
    });
    return lines;
}

// An undisturbed run: the sums after each number of frame records, and the index of the arrival that follows.
struct Reference {
    std::vector<Bytes> states;
    std::vector<size_t> next = {0};
};

inline Reference reference_of(const std::vector<Arrival> &arrivals) {
    Reference reference;
    Disk disk;
    Run run(std::make_unique<FakeStore>(disk), 1);
    reference.states.push_back(run.sums.save());
    for (size_t i = 0; i < arrivals.size(); i++) {
        run.push(arrivals[i]);
        if (frame_records(run) < reference.states.size())
            continue;
        reference.states.push_back(run.sums.save());
        reference.next.push_back(i + 1);
    }
    return reference;
}

inline bool matches_its_records(const Run &run, const Reference &reference) {
    const uint64_t lines = frame_records(run);
    return lines < reference.states.size() && run.sums.save() == reference.states[lines];
}

// Pushes every arrival after those that the run has records of.
template <class After>
void push_remaining(Run &run, const std::vector<Arrival> &arrivals, const Reference &reference, After after) {
    for (size_t i = reference.next.at(frame_records(run)); i < arrivals.size(); i++) {
        run.push(arrivals[i]);
        after(i);
    }
}

inline int failures = 0;

inline void expect(bool holds, const char *what, uint64_t seed) {
    if (holds)
        return;
    std::printf("seed %llu: %s\n", static_cast<unsigned long long>(seed), what);
    failures++;
}

} // namespace fault
