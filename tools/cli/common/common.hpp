// What most files of the program use: containers, text, the library, failures, files, JSON and progress.
#pragma once
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <toliman/toliman.hpp>

#include "common/failure.hpp"
#include "common/input.hpp"
#include "common/json.hpp"
#include "common/library.hpp"
#include "common/output.hpp"
#include "common/stop.hpp"
#include "common/terminal.hpp"
#include "common/text.hpp"

namespace CLI {
class App;
class Option;
} // namespace CLI
