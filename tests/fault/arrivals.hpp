// A pass of small frames with everything that happens on the way, and trackers of it upon a fake disk.
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

struct Arrival {
    uint16_t pixels[kPixels];
    int64_t id;
    track::Frame frame() const {
        return {"pass", "core", id, id * 1000, 0, pixels, kSide, kSide, kSide, Pixel::u16, 0, 0, nullptr, 0, 0, 0};
    }
};

// Some come twice, some with other bytes, some damaged, some are outliers.
inline std::vector<Arrival> make_arrivals(size_t count, std::mt19937_64 &random) {
    std::vector<Arrival> arrivals;
    while (arrivals.size() < count) {
        Arrival arrival = {};
        for (uint16_t &pixel : arrival.pixels)
            pixel = static_cast<uint16_t>(1 + random() % 1000);
        arrival.id = static_cast<int64_t>(arrivals.size());
        const uint64_t fate = random() % 10;
        if (!arrivals.empty() && fate < 3) {
            arrival = arrivals[random() % arrivals.size()];
            if (fate < 2)
                arrival.pixels[0] = static_cast<uint16_t>(arrival.pixels[0] ^ 1);
        }
        if (fate == 3)
            arrival.pixels[5] = 60000;
        if (fate == 4)
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

// A tracker with its sums.
struct Run {
    Run(std::unique_ptr<FakeStore> store, size_t group, track::Sync sync = track::Sync::group) : sums(grid()) {
        const track::Plan plan = make_plan(group, sync);
        track::Place place = track::open_place(std::move(store), Access::write, plan.terms);
        tracker.emplace(
            plan,
            [](const double *image, const track::Frame &, int64_t, unsigned, track::Estimated &estimated) {
                estimated.value = (image[0] - image[1] + image[2]) / 1024;
            },
            std::move(place), sums);
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

// Lines that are not marks, which count repeats.
inline uint64_t lines_of_frames(const Run &run) {
    uint64_t lines = 0;
    run.tracker->visit(0, run.tracker->lines(), [&](const track::Record &record, const track::Outcome &) {
        lines += record.kind != track::Kind::merged;
    });
    return lines;
}

// A run that nothing befell: the sums after so many lines of frames, and the arrival that comes next then.
struct Course {
    std::vector<Bytes> states;
    std::vector<size_t> next = {0};
};

inline Course course_of(const std::vector<Arrival> &arrivals) {
    Course course;
    Disk disk;
    Run run(std::make_unique<FakeStore>(disk), 1);
    course.states.push_back(run.sums.save());
    for (size_t i = 0; i < arrivals.size(); i++) {
        run.push(arrivals[i]);
        if (lines_of_frames(run) < course.states.size())
            continue;
        course.states.push_back(run.sums.save());
        course.next.push_back(i + 1);
    }
    return course;
}

inline bool holds_its_lines(const Run &run, const Course &course) {
    const uint64_t lines = lines_of_frames(run);
    return lines < course.states.size() && run.sums.save() == course.states[lines];
}

// Everything behind the lines that a run has.
template <class After>
void push_the_rest(Run &run, const std::vector<Arrival> &arrivals, const Course &course, After after) {
    for (size_t i = course.next.at(lines_of_frames(run)); i < arrivals.size(); i++) {
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
