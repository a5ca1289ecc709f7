#include "backend/netcdf.hpp"

#include "base/error.hpp"

#ifdef TOLIMAN_NETCDF // the name of the shared library
#include <algorithm>
#include <dlfcn.h>
#include <mutex>
#include <netcdf.h>
#include <type_traits>

#include "backend/file.hpp"

namespace toliman::netcdf {

namespace {

constexpr size_t kMostDimensions = 4, kLongestText = 65536, kLargestChunk = size_t{256} << 20;

// The functions of the library that are used.
struct Functions {
    decltype(&::nc_open) open;
    decltype(&::nc_close) close;
    decltype(&::nc_strerror) strerror;
    decltype(&::nc_inq_libvers) inq_libvers;
    decltype(&::nc_inq_varid) inq_varid;
    decltype(&::nc_inq_var) inq_var;
    decltype(&::nc_inq_dimlen) inq_dimlen;
    decltype(&::nc_inq_var_chunking) inq_var_chunking;
    decltype(&::nc_set_var_chunk_cache) set_var_chunk_cache;
    decltype(&::nc_get_vara_int) get_vara_int;
    decltype(&::nc_get_vara_longlong) get_vara_longlong;
    decltype(&::nc_get_vara_double) get_vara_double;
    decltype(&::nc_inq_att) inq_att;
    decltype(&::nc_get_att_text) get_att_text;
    decltype(&::nc_get_att_string) get_att_string;
    decltype(&::nc_get_att_double) get_att_double;
    decltype(&::nc_free_string) free_string;
};

std::mutex mutex; // of the state of netCDF, and of what follows
Functions nc;
bool is_loaded = false;
std::string text_of_version;

// The library stays loaded. False if it is not installed.
bool load() {
    if (is_loaded)
        return true;
    void *const library = ::dlopen(TOLIMAN_NETCDF, RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr)
        return false;
    bool is_complete = true;
    const auto find = [&](const char *name, auto &function) {
        function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(::dlsym(library, name));
        is_complete = is_complete && function != nullptr;
    };
    find("nc_open", nc.open);
    find("nc_close", nc.close);
    find("nc_strerror", nc.strerror);
    find("nc_inq_libvers", nc.inq_libvers);
    find("nc_inq_varid", nc.inq_varid);
    find("nc_inq_var", nc.inq_var);
    find("nc_inq_dimlen", nc.inq_dimlen);
    find("nc_inq_var_chunking", nc.inq_var_chunking);
    find("nc_set_var_chunk_cache", nc.set_var_chunk_cache);
    find("nc_get_vara_int", nc.get_vara_int);
    find("nc_get_vara_longlong", nc.get_vara_longlong);
    find("nc_get_vara_double", nc.get_vara_double);
    find("nc_inq_att", nc.inq_att);
    find("nc_get_att_text", nc.get_att_text);
    find("nc_get_att_string", nc.get_att_string);
    find("nc_get_att_double", nc.get_att_double);
    find("nc_free_string", nc.free_string);
    if (!is_complete)
        return false;
    const std::string whole = nc.inq_libvers(); // "4.9.0 of Jan 18 2023 ..."
    text_of_version = whole.substr(0, whole.find(' '));
    return is_loaded = true;
}

// netCDF takes other names for URLs.
std::string plain_name(const std::string &path) {
    return path.compare(0, 1, "/") == 0 ? path : "./" + path;
}

bool is_integer(nc_type type) noexcept {
    return type == NC_BYTE || type == NC_UBYTE || type == NC_SHORT || type == NC_USHORT || type == NC_INT ||
           type == NC_UINT || type == NC_INT64 || type == NC_UINT64;
}

} // namespace

const char *version() {
    const std::lock_guard lock(mutex);
    return load() ? text_of_version.c_str() : "";
}

File::File(const std::string &path) : path_(path) {
    constexpr uint8_t kHdf5[] = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
    const std::vector<uint8_t> head = file::head(path, sizeof kHdf5);
    if (head.size() < sizeof kHdf5 || !std::equal(head.begin(), head.end(), kHdf5))
        fail(Status::format, "{%s}: is not a netCDF-4 file", path.c_str());
    const std::lock_guard lock(mutex);
    if (!load())
        fail(Status::unsupported, "{%s}: cannot be read: the library netCDF, %s, is not installed", path.c_str(),
             TOLIMAN_NETCDF);
    check(nc.open(plain_name(path).c_str(), NC_NOWRITE, &file_), "the file");
}

File::~File() {
    const std::lock_guard lock(mutex);
    nc.close(file_);
}

void File::check(int status, const char *what) const {
    if (status == NC_ENOMEM)
        fail(Status::memory, "netCDF: out of memory");
    if (status != NC_NOERR)
        fail(Status::format, "{%s}: %.60s is damaged or cannot be read: %s", path_.c_str(), what, nc.strerror(status));
}

int File::id_of(const char *variable) const {
    int id = 0;
    const int status = nc.inq_varid(file_, variable, &id);
    if (status == NC_ENOTVAR)
        fail(Status::format, "{%s}: there is no variable %s", path_.c_str(), variable);
    check(status, variable);
    return id;
}

bool File::has(const char *variable) const {
    const std::lock_guard lock(mutex);
    int id = 0;
    return nc.inq_varid(file_, variable, &id) == NC_NOERR;
}

std::vector<size_t> File::shape(const char *variable, bool integers) const {
    const std::lock_guard lock(mutex);
    const int id = id_of(variable);
    nc_type type = 0;
    int count = 0, is_chunked = 0;
    check(nc.inq_var(file_, id, nullptr, &type, &count, nullptr, nullptr), variable);
    if (integers ? !is_integer(type) : !is_integer(type) && type != NC_FLOAT && type != NC_DOUBLE)
        fail(Status::format, "{%s}: %s must be of %s", path_.c_str(), variable, integers ? "integers" : "numbers");
    if (count < 1 || count > static_cast<int>(kMostDimensions))
        fail(Status::format, "{%s}: %s has %d dimensions", path_.c_str(), variable, count);
    int dimensions[kMostDimensions];
    size_t chunk[kMostDimensions];
    check(nc.inq_var(file_, id, nullptr, nullptr, nullptr, dimensions, nullptr), variable);
    check(nc.inq_var_chunking(file_, id, &is_chunked, chunk), variable);
    std::vector<size_t> lengths(static_cast<size_t>(count));
    size_t bytes = sizeof(double);
    for (size_t i = 0; i < lengths.size(); i++) {
        check(nc.inq_dimlen(file_, dimensions[i], &lengths[i]), variable);
        if (is_chunked != NC_CHUNKED)
            continue;
        if (chunk[i] > kLargestChunk / bytes)
            fail(Status::format, "{%s}: %s has chunks of more than %zu bytes", path_.c_str(), variable, kLargestChunk);
        bytes *= chunk[i];
    }
    if (is_chunked == NC_CHUNKED) // a chunk is unpacked once, although it holds several frames
        check(nc.set_var_chunk_cache(file_, id, bytes, 11, 1), variable);
    return lengths;
}

void File::read(const char *variable, const size_t *start, const size_t *count, int32_t *values) const {
    const std::lock_guard lock(mutex);
    check(nc.get_vara_int(file_, id_of(variable), start, count, values), variable);
}

void File::read(const char *variable, const size_t *start, const size_t *count, int64_t *values) const {
    static_assert(sizeof(long long) == sizeof(int64_t));
    const std::lock_guard lock(mutex);
    check(nc.get_vara_longlong(file_, id_of(variable), start, count, reinterpret_cast<long long *>(values)), variable);
}

void File::read(const char *variable, const size_t *start, const size_t *count, double *values) const {
    const std::lock_guard lock(mutex);
    check(nc.get_vara_double(file_, id_of(variable), start, count, values), variable);
}

std::optional<std::string> File::text(const std::string &attribute) const {
    const std::lock_guard lock(mutex);
    const char *const name = attribute.c_str();
    nc_type type = 0;
    size_t length = 0;
    if (nc.inq_att(file_, NC_GLOBAL, name, &type, &length) != NC_NOERR)
        return std::nullopt;
    if (type == NC_STRING && length == 1) {
        char *text = nullptr;
        check(nc.get_att_string(file_, NC_GLOBAL, name, &text), name);
        const std::string copy = text != nullptr ? text : "";
        nc.free_string(1, &text);
        return copy;
    }
    if (type != NC_CHAR || length > kLongestText)
        return std::nullopt;
    std::string text(length, '\0');
    check(nc.get_att_text(file_, NC_GLOBAL, name, text.data()), name);
    return text.substr(0, text.find('\0'));
}

std::optional<double> File::number(const std::string &attribute, const char *variable) const {
    const std::lock_guard lock(mutex);
    const char *const name = attribute.c_str();
    const int id = variable != nullptr ? id_of(variable) : NC_GLOBAL;
    nc_type type = 0;
    size_t length = 0;
    if (nc.inq_att(file_, id, name, &type, &length) != NC_NOERR || length != 1 || type == NC_CHAR || type == NC_STRING)
        return std::nullopt;
    double value = 0;
    check(nc.get_att_double(file_, id, name, &value), name);
    return value;
}

} // namespace toliman::netcdf

#else

namespace toliman::netcdf {

const char *version() {
    return "";
}

File::File(const std::string &path) : path_(path) {
    fail(Status::unsupported, "{%s}: cannot be read: libtoliman was built without netCDF", path.c_str());
}

File::~File() = default;

bool File::has(const char *) const {
    return false;
}

std::vector<size_t> File::shape(const char *, bool) const {
    return {};
}

void File::read(const char *, const size_t *, const size_t *, int32_t *) const {}
void File::read(const char *, const size_t *, const size_t *, int64_t *) const {}
void File::read(const char *, const size_t *, const size_t *, double *) const {}

std::optional<std::string> File::text(const std::string &) const {
    return std::nullopt;
}

std::optional<double> File::number(const std::string &, const char *) const {
    return std::nullopt;
}

} // namespace toliman::netcdf
#endif
