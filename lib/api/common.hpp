// What most files of lib/api use.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/accept.hpp"
#include "api/choice.hpp"
#include "api/goodness.hpp"
#include "api/handle.hpp"
#include "api/members.hpp"
#include "api/memory.hpp"
#include "api/output.hpp"
