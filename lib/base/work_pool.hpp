// Working memory of an object's calls, kept from call to call.
#pragma once
#include <functional>
#include <memory>
#include <mutex>
#include <utility>

namespace toliman {

// One Work from the start, and one more for each call beyond the largest number of calls that ran at once before. Any
// number of threads may lease one.
template <class Work> class WorkPool {
    struct Node {
        Work work;
        std::unique_ptr<Node> next;
    };

  public:
    explicit WorkPool(std::function<Work()> make) : make_(std::move(make)), free_(fresh()) {}

    // A Work for the current scope.
    class Lease {
      public:
        explicit Lease(WorkPool &owner) : owner_(owner), node_(owner.take()) {}
        ~Lease() { owner_.give_back(std::move(node_)); }
        Lease(const Lease &) = delete;
        Lease &operator=(const Lease &) = delete;
        Work &operator*() noexcept { return node_->work; }

      private:
        WorkPool &owner_;
        std::unique_ptr<Node> node_;
    };

  private:
    std::unique_ptr<Node> fresh() const { return std::unique_ptr<Node>(new Node{make_(), nullptr}); }
    std::unique_ptr<Node> take() {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (free_ == nullptr)
            return fresh();
        std::unique_ptr<Node> node = std::move(free_);
        free_ = std::move(node->next);
        return node;
    }
    void give_back(std::unique_ptr<Node> node) noexcept {
        const std::lock_guard<std::mutex> lock(mutex_);
        node->next = std::move(free_);
        free_ = std::move(node);
    }

    std::function<Work()> make_;
    std::mutex mutex_;
    std::unique_ptr<Node> free_;
};

} // namespace toliman
