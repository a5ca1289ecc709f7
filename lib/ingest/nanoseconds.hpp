// Times in another unit than nanoseconds.
#pragma once
#include <cstddef>
#include <cstdint>

namespace toliman::ingest {

// Status::argument, naming the argument, if all times are near 1970-01-01: they are not nanoseconds.
void check_nanoseconds(const char *name, const int64_t *times, size_t count);

} // namespace toliman::ingest
