// Base of interfaces.
#pragma once

namespace cli {

// Their objects are not copied.
class Interface {
  public:
    Interface(const Interface &) = delete;
    Interface &operator=(const Interface &) = delete;
    virtual ~Interface() = default;

  protected:
    Interface() = default;
};

} // namespace cli
