#include "backend/xml.hpp"

#include <algorithm>
#include <exception>
#include <expat.h>
#include <memory>

#include "base/error.hpp"

namespace toliman::xml {

namespace {

constexpr size_t kMostLevels = 32, kLongestText = 4096;

// Exceptions must not cross Expat: the parser is stopped, and the exception is thrown again after it.
class Reader {
  public:
    Reader(const char *path, const Sink &sink) : path_(path), sink_(sink), parser_(XML_ParserCreate(nullptr)) {
        if (!parser_)
            fail(Status::memory, "XML: out of memory");
        XML_SetUserData(parser_.get(), this);
        XML_SetElementHandler(parser_.get(), on_begin, on_end);
        XML_SetCharacterDataHandler(parser_.get(), on_text);
        XML_SetStartDoctypeDeclHandler(parser_.get(), on_doctype);
    }

    void read(std::string_view text) {
        constexpr size_t kChunk = size_t{1} << 20;
        XML_Status status = XML_STATUS_OK;
        bool is_last = false;
        for (size_t at = 0; !is_last && status == XML_STATUS_OK; at += kChunk) {
            const std::string_view part = text.substr(std::min(at, text.size()), kChunk);
            is_last = at + kChunk >= text.size();
            status = XML_Parse(parser_.get(), part.data(), static_cast<int>(part.size()), is_last ? 1 : 0);
        }
        if (failure_)
            std::rethrow_exception(failure_);
        const XML_Error error = XML_GetErrorCode(parser_.get());
        if (status == XML_STATUS_OK)
            return;
        if (error == XML_ERROR_NO_MEMORY)
            fail(Status::memory, "XML: out of memory");
        refuse(XML_ErrorString(error));
    }

  private:
    [[noreturn]] void refuse(const char *why) const {
        fail(Status::format, "{%s}:%d: is not valid XML: %s", path_, line(), why);
    }

    int line() const noexcept {
#if XML_MAJOR_VERSION == 2 && XML_MINOR_VERSION < 9
        return static_cast<int>(XML_GetCurrentLineNumber(parser_.get()));
#else
        return static_cast<int>(XML_GetCurrentLineNumber64(parser_.get()));
#endif
    }

    template <class Work> void guard(const Work &work) noexcept {
        if (failure_)
            return;
        try {
            work();
        } catch (...) {
            failure_ = std::current_exception();
            XML_StopParser(parser_.get(), XML_FALSE);
        }
    }

    static std::string local_name(const char *name) {
        const std::string_view text(name);
        return std::string(text.substr(text.find(':') + 1)); // npos + 1 = 0
    }

    static void on_begin(void *data, const char *name, const char **attributes) noexcept {
        auto &self = *static_cast<Reader *>(data);
        self.guard([&] {
            if (self.open_.size() == kMostLevels)
                self.refuse("too many levels");
            Element element;
            element.name = local_name(name);
            element.line = self.line();
            for (size_t i = 0; attributes[i] != nullptr; i += 2)
                element.attributes.emplace_back(attributes[i], attributes[i + 1]);
            self.open_.push_back(std::move(element));
            self.sink_.begin(self.open_.back());
        });
    }

    static void on_end(void *data, const char *) noexcept {
        auto &self = *static_cast<Reader *>(data);
        self.guard([&] {
            self.sink_.end(self.open_.back());
            self.open_.pop_back();
        });
    }

    static void on_text(void *data, const char *text, int length) noexcept {
        auto &self = *static_cast<Reader *>(data);
        self.guard([&] {
            std::string &all = self.open_.back().text;
            if (all.size() + static_cast<size_t>(length) > kLongestText)
                self.refuse("an element has more than 4096 bytes of text");
            all.append(text, static_cast<size_t>(length));
        });
    }

    static void on_doctype(void *data, const char *, const char *, const char *, int) noexcept {
        auto &self = *static_cast<Reader *>(data);
        self.guard([&] { self.refuse("a document type is not allowed"); });
    }

    struct Free {
        void operator()(XML_Parser parser) const noexcept { XML_ParserFree(parser); }
    };
    const char *path_;
    const Sink &sink_;
    std::unique_ptr<XML_ParserStruct, Free> parser_;
    std::vector<Element> open_; // from the root to the current one
    std::exception_ptr failure_;
};

} // namespace

std::string Element::attribute(std::string_view wanted) const {
    const auto found = std::find_if(attributes.begin(), attributes.end(),
                                    [&](const auto &attribute) { return attribute.first == wanted; });
    return found != attributes.end() ? found->second : "";
}

void parse(const char *path, std::string_view text, const Sink &sink) {
    Reader(path, sink).read(text);
}

} // namespace toliman::xml
