// A shared library that is loaded when it is first used, and stays loaded.
#pragma once
#include <dlfcn.h>

namespace cli {

class SharedLibrary {
  public:
    explicit SharedLibrary(const char *name) : handle_(::dlopen(name, RTLD_NOW | RTLD_LOCAL)) {}

    // A function of the library, which becomes a pointer of the type to which it is assigned.
    struct Symbol {
        void *address;
        template <typename Function> operator Function() const noexcept { return reinterpret_cast<Function>(address); }
    };
    Symbol find(const char *name) noexcept {
        void *const found = handle_ == nullptr ? nullptr : ::dlsym(handle_, name);
        is_complete_ = is_complete_ && found != nullptr;
        return {found};
    }

    // Whether it is there and has every function that was to be found.
    bool is_complete() const noexcept { return is_complete_; }

  private:
    void *handle_;
    bool is_complete_ = true;
};

} // namespace cli
