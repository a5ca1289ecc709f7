// Method: one pass over the tokens (Scan) before cJSON parses the text. cJSON 1.7 accepts more than JSON and more than
// is safe: it recurses to 1000 levels, converts 1e999 to infinity, and accepts invalid UTF-8, control characters in
// strings and numbers such as 01. The scan rejects these with line and column, and bounds the nesting depth and the
// number of values, hence also the memory. It does not check the order of tokens, which is left to cJSON. The result is
// converted to plain values; duplicate keys are rejected then. cJSON rounds integers to double. The scan therefore
// keeps each number's exact integer: both meet the numbers in document order, so the k-th number of the tree is the
// k-th token.
#include "backend/json.hpp"

#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <new>
#include <set>
#include <string_view>
#include <utility>

#include <cjson/cJSON.h>

#include "base/error.hpp"
#include "base/text.hpp"

namespace toliman::json {

namespace {

constexpr size_t kMostLevels = 16; // of nested arrays and objects
constexpr size_t kMostValues = 4096;

[[noreturn]] void fail_at(const std::string &text, size_t offset, const std::string &source, Form form,
                          const char *what) {
    size_t line = 1, column = 1;
    for (size_t i = 0; i < offset && i < text.size(); i++) {
        column = text[i] == '\n' ? 1 : column + 1;
        line += text[i] == '\n';
    }
    if (form == Form::line)
        fail(Status::format, "{%s}: column %zu: %s", source.c_str(), column, what);
    fail(Status::format, "{%s}: line %zu, column %zu: %s", source.c_str(), line, column, what);
}

// Length of the UTF-8 sequence at text[at], 0 if it is malformed (Unicode 15, table 3-7).
size_t utf8_length(const std::string &text, size_t at) {
    const auto byte = [&](size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
    const auto is = [&](size_t i, unsigned low, unsigned high) { return byte(i) >= low && byte(i) <= high; };
    const unsigned first = byte(at);
    if (first < 0x80)
        return 1;
    if (first >= 0xc2 && first <= 0xdf)
        return is(at + 1, 0x80, 0xbf) ? 2 : 0;
    if (first >= 0xe0 && first <= 0xef) {
        const unsigned low = first == 0xe0 ? 0xa0 : 0x80, high = first == 0xed ? 0x9f : 0xbf;
        return is(at + 1, low, high) && is(at + 2, 0x80, 0xbf) ? 3 : 0;
    }
    if (first >= 0xf0 && first <= 0xf4) {
        const unsigned low = first == 0xf0 ? 0x90 : 0x80, high = first == 0xf4 ? 0x8f : 0xbf;
        return is(at + 1, low, high) && is(at + 2, 0x80, 0xbf) && is(at + 3, 0x80, 0xbf) ? 4 : 0;
    }
    return 0;
}

class Scan {
  public:
    // Starts after a byte order mark (U+FEFF), which some editors write and cJSON skips.
    Scan(const std::string &text, const std::string &source, Form form)
        : text_(text), source_(source), form_(form), at_(text.compare(0, 3, "\xef\xbb\xbf") == 0 ? 3 : 0) {}

    // The exact integer of each number, in document order; empty where the number is not a 64-bit integer.
    std::vector<std::optional<int64_t>> run() {
        while (at_ < text_.size())
            token();
        return std::move(integers_);
    }

  private:
    [[noreturn]] void refuse(const char *what) const { fail_at(text_, at_, source_, form_, what); }
    char here() const { return at_ < text_.size() ? text_[at_] : '\0'; }
    bool digit() const { return here() >= '0' && here() <= '9'; }

    void token() {
        switch (here()) {
        case ' ':
        case '\t':
        case '\r':
        case '\n':
        case ',':
            at_++;
            return;
        case ':':
            at_++;
            keys_++;
            return;
        case ']':
        case '}':
            if (levels_-- == 0)
                refuse("closing bracket without an opening one");
            at_++;
            return;
        case '[':
        case '{':
            value();
            if (++levels_ > kMostLevels)
                refuse("nested deeper than 16 levels");
            at_++;
            return;
        case '"':
            value();
            return string();
        default:
            value();
            return here() == '-' || digit() ? number() : literal();
        }
    }

    void value() {
        if (++values_ > kMostValues + keys_)
            refuse("more than 4096 values");
    }

    void string() {
        for (at_++; here() != '"'; at_++) {
            if (at_ >= text_.size())
                refuse("unterminated string");
            if (static_cast<unsigned char>(here()) < 0x20)
                refuse("control character in a string");
            const size_t length = utf8_length(text_, at_);
            if (length == 0)
                refuse("invalid UTF-8");
            if (text_.compare(at_, 6, "\\u0000") == 0)
                refuse("U+0000 is not allowed");
            at_ += here() == '\\' ? 1 : length - 1;
        }
        at_++;
    }

    void digits() {
        if (!digit())
            refuse("expected a digit");
        while (digit())
            at_++;
    }

    void number() {
        const size_t start = at_;
        at_ += here() == '-';
        if (here() == '0')
            at_++;
        else
            digits();
        if (here() == '.') {
            at_++;
            digits();
        }
        if (here() == 'e' || here() == 'E') {
            at_++;
            at_ += here() == '-' || here() == '+';
            digits();
        }
        double parsed;
        const auto [end, error] = std::from_chars(text_.data() + start, text_.data() + at_, parsed);
        if (error != std::errc() || end != text_.data() + at_) {
            at_ = start;
            refuse("number outside the range of double");
        }
        if (digit())
            refuse("number with a leading zero");
        int64_t integer;
        const auto [stop, range] = std::from_chars(text_.data() + start, text_.data() + at_, integer);
        const bool exact = range == std::errc() && stop == text_.data() + at_;
        integers_.push_back(exact ? std::optional<int64_t>(integer) : std::nullopt);
    }

    void literal() {
        for (const char *word : {"true", "false", "null"})
            if (text_.compare(at_, std::strlen(word), word) == 0) {
                at_ += std::strlen(word);
                return;
            }
        refuse(at_ < text_.size() && text_[at_] == '\0' ? "unexpected zero byte" : "unexpected character");
    }

    const std::string &text_;
    const std::string &source_;
    Form form_;
    size_t at_, levels_ = 0, values_ = 0, keys_ = 0;
    std::vector<std::optional<int64_t>> integers_;
};

// Converts a node of the tree; `integer` is that of the next number. Recursion is bounded by kMostLevels.
Value convert(const cJSON &node, const std::string &source, Form form, const std::optional<int64_t> *&integer) {
    Value value;
    if (cJSON_IsBool(&node)) {
        value.kind = Value::Kind::boolean;
        value.boolean = cJSON_IsTrue(&node) != 0;
    } else if (cJSON_IsNumber(&node)) {
        value.kind = Value::Kind::number;
        value.number = node.valuedouble;
        value.integer = *integer++;
    } else if (cJSON_IsString(&node)) {
        value.kind = Value::Kind::text;
        value.text = node.valuestring;
    } else if (cJSON_IsArray(&node) || cJSON_IsObject(&node)) {
        const bool object = cJSON_IsObject(&node) != 0;
        std::set<std::string_view> names; // keys so far, for a lookup in logarithmic time
        value.kind = object ? Value::Kind::object : Value::Kind::array;
        for (const cJSON *item = node.child; item != nullptr; item = item->next) {
            if (object && form == Form::document && !names.insert(item->string).second)
                fail(Status::format, "{%s}: duplicate key \"%s\"", source.c_str(), item->string);
            value.items.push_back(convert(*item, source, form, integer));
            if (object)
                value.names.emplace_back(item->string);
        }
    }
    return value;
}

} // namespace

const Value *Value::find(const std::string &name) const noexcept {
    for (size_t i = 0; i < names.size(); i++)
        if (names[i] == name)
            return &items[i];
    return nullptr;
}

Value &Value::member(const std::string &name) {
    kind = Kind::object;
    for (size_t i = 0; i < names.size(); i++)
        if (names[i] == name)
            return items[i];
    names.push_back(name);
    return items.emplace_back();
}

void Value::remove(const std::string &name) {
    for (size_t i = 0; i < names.size(); i++)
        if (names[i] == name) {
            names.erase(names.begin() + static_cast<ptrdiff_t>(i));
            items.erase(items.begin() + static_cast<ptrdiff_t>(i));
            return;
        }
}

Value Value::of(double number) {
    Value value;
    value.kind = Kind::number;
    value.number = number;
    return value;
}

Value Value::of(const std::string &text) {
    Value value;
    value.kind = Kind::text;
    value.text = text;
    return value;
}

namespace {

using Tree = std::unique_ptr<cJSON, void (*)(cJSON *)>;

Tree known(cJSON *node) {
    if (node == nullptr)
        throw std::bad_alloc();
    return {node, cJSON_Delete};
}

// cJSON prints 15 digits if these are the number up to its last bit; here they must be the number itself.
Tree number_of(double number) {
    char text[40];
    const size_t length = print_text(text, sizeof text, "%.15g", number);
    double read = 0;
    std::from_chars(text, text + length, read);
    if (read == number)
        return known(cJSON_CreateNumber(number));
    print_text(text, sizeof text, "%.17g", number);
    return known(cJSON_CreateRaw(text));
}

Tree tree_of(const Value &value) {
    switch (value.kind) {
    case Value::Kind::null:
        return known(cJSON_CreateNull());
    case Value::Kind::boolean:
        return known(cJSON_CreateBool(value.boolean ? 1 : 0));
    case Value::Kind::number:
        return value.integer ? known(cJSON_CreateRaw(std::to_string(*value.integer).c_str())) : number_of(value.number);
    case Value::Kind::text:
        return known(cJSON_CreateString(value.text.c_str()));
    case Value::Kind::array:
    case Value::Kind::object:
        break;
    }
    const bool object = value.kind == Value::Kind::object;
    Tree tree = known(object ? cJSON_CreateObject() : cJSON_CreateArray());
    for (size_t i = 0; i < value.items.size(); i++) {
        Tree item = tree_of(value.items[i]);
        const bool added = object ? cJSON_AddItemToObject(tree.get(), value.names[i].c_str(), item.get()) != 0
                                  : cJSON_AddItemToArray(tree.get(), item.get()) != 0;
        if (!added)
            throw std::bad_alloc();
        (void)item.release();
    }
    return tree;
}

} // namespace

std::string print(const Value &value) {
    const std::unique_ptr<char, void (*)(void *)> text(cJSON_Print(tree_of(value).get()), cJSON_free);
    if (text == nullptr)
        throw std::bad_alloc();
    return text.get() + std::string("\n");
}

Value parse(const std::string &text, const std::string &source, Form form) {
    if (text.find_first_not_of(" \t\r\n") == std::string::npos)
        fail(Status::format, "{%s}: is empty", source.c_str());
    const std::vector<std::optional<int64_t>> integers = Scan(text, source, form).run();
    const char *end = nullptr;
    errno = 0; // cJSON does not distinguish exhausted memory from bad syntax; malloc sets errno
    const std::unique_ptr<cJSON, void (*)(cJSON *)> tree(
        cJSON_ParseWithLengthOpts(text.c_str(), text.size() + 1, &end, 1), cJSON_Delete);
    if (tree == nullptr && errno == ENOMEM)
        throw std::bad_alloc();
    if (tree == nullptr)
        fail_at(text, end != nullptr ? static_cast<size_t>(end - text.c_str()) : text.size(), source, form,
                "JSON syntax error");
    const std::optional<int64_t> *next = integers.data();
    return convert(*tree, source, form, next);
}

} // namespace toliman::json
