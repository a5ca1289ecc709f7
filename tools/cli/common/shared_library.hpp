// A shared library that is loaded when it is first used, and stays loaded.
#pragma once
#include <dlfcn.h>
#include <type_traits>

namespace cli {

class SharedLibrary {
  public:
    explicit SharedLibrary(const char *name) : handle_(::dlopen(name, RTLD_NOW | RTLD_LOCAL)) {}

    template <typename Function> void find(const char *name, Function &function) {
        void *const found = handle_ == nullptr ? nullptr : ::dlsym(handle_, name);
        function = reinterpret_cast<Function>(found);
        is_complete_ = is_complete_ && found != nullptr;
    }

    // Whether it is there and has every function that was to be found.
    bool is_complete() const noexcept { return is_complete_; }

  private:
    void *handle_;
    bool is_complete_ = true;
};

} // namespace cli
