// Working memory of encoding, kept from call to call.
#pragma once
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "base/buffer.hpp"
#include "cae/encoder_rows.hpp"
#include "cae/preprocess.hpp"

namespace toliman::cae {

// Working memory of one thread; reuse it to avoid allocations.
struct Workspace {
    Preprocess::Work input;
    std::vector<EncoderRows> rows; // of layout `flight`, one per frame
    std::optional<Images> images;  // of layout `paper`, whose switches need whole images

    // Allocates what `frames` frames need that are encoded together.
    void prepare(const Layout &layout, const Preprocess &preprocess, size_t frames) {
        input.reserve(preprocess, frames);
        if (layout.max_pool && !images)
            images.emplace();
        while (!layout.max_pool && rows.size() < frames)
            rows.emplace_back();
    }
    std::unique_ptr<Workspace> next; // of the list of Workspaces
};

// The workspaces of an object: one from the start, and one more for each call beyond the largest number of calls that
// ran at once before. take() may be called from any thread.
class Workspaces {
  public:
    Workspaces(const Layout &layout, const Preprocess &preprocess) : free_(std::make_unique<Workspace>()) {
        free_->prepare(layout, preprocess, 1);
    }

    // A workspace for the current scope.
    class Lease {
      public:
        explicit Lease(Workspaces &owner) : owner_(owner), work_(owner.take()) {}
        ~Lease() { owner_.give_back(std::move(work_)); }
        Lease(const Lease &) = delete;
        Lease &operator=(const Lease &) = delete;
        Workspace &operator*() noexcept { return *work_; }

      private:
        Workspaces &owner_;
        std::unique_ptr<Workspace> work_;
    };

  private:
    std::unique_ptr<Workspace> take() {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (free_ == nullptr)
            return std::make_unique<Workspace>();
        std::unique_ptr<Workspace> work = std::move(free_);
        free_ = std::move(work->next);
        return work;
    }
    void give_back(std::unique_ptr<Workspace> work) noexcept {
        const std::lock_guard<std::mutex> lock(mutex_);
        work->next = std::move(free_);
        free_ = std::move(work);
    }

    std::mutex mutex_;
    std::unique_ptr<Workspace> free_;
};

} // namespace toliman::cae
