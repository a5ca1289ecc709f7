// A file descriptor that is closed at the end of its scope.
#pragma once
#include <unistd.h>

namespace toliman {

class Descriptor {
  public:
    explicit Descriptor(int number) noexcept : number_(number) {} // negative: none
    ~Descriptor() {
        if (number_ >= 0)
            ::close(number_);
    }
    Descriptor(const Descriptor &) = delete;
    Descriptor &operator=(const Descriptor &) = delete;
    int get() const noexcept { return number_; }

  private:
    int number_;
};

} // namespace toliman
