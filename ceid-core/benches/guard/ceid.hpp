// The guard of the paper, from its figures: 8 (operator), 9 (check), A4 (uniqueness), A5 (destructor), in one class.
// Two mistakes of the printed figures are put right, without which they do not compile or update copies: A5 takes the
// tail of the filters by value, and initializes from a parameter that has another name.
// Built by the benchmark only.
#pragma once

#include <cassert>
#include <type_traits>
#include <utility>

template <typename T, typename U>
class CEIDEqualComparable {
    friend bool operator==(T const& a, U const& b) { return a.equal_to(b); }
};

template <class...>
class UniqueCheck;

template <>
class UniqueCheck<> {
public:
    UniqueCheck() {}
    bool isUnique() const { return true; }
    const void* searchImpl(const void*) const { return nullptr; }
};

template <class THead, class... TTails>
class UniqueCheck<THead, TTails...> : public UniqueCheck<TTails...> {
public:
    UniqueCheck(THead const& t, const TTails&... args) : UniqueCheck<TTails...>(args...), pointer_(&t) {
        assert(true == isUnique());
    }
    bool isUnique() const {
        return (pointer_ == UniqueCheck<TTails...>::searchImpl(pointer_)) ? false : UniqueCheck<TTails...>::isUnique();
    }
    const void* searchImpl(const void* p) const {
        return (p == pointer_ ? pointer_ : UniqueCheck<TTails...>::searchImpl(p));
    }

public:
    const void* pointer_;
};

template <class... TTails>
class CEID;

template <>
class CEID<> {};

template <class THead, class... TTails>
class CEID<THead, TTails...> : public CEID<TTails...>, private CEIDEqualComparable<CEID<THead, TTails...>, THead> {
public:
    explicit CEID(THead& filter, TTails&... args) : CEID<TTails...>(args...), cyclicObject_(filter) {
        UniqueCheck<THead, TTails...> uniqueCheck(filter, args...);
    }
    ~CEID() { cyclicObject_.update(); }
    bool equal_to(THead const&) const { return false; }

private:
    THead& cyclicObject_;
};

struct is_update_per_cycle_once_impl {
    template <class T, class U>
    static auto check(T*, U*) -> decltype(std::declval<T>() == std::declval<U>(), std::true_type());
    template <class T, class U>
    static auto check(...) -> std::false_type;
};

template <class T, class U>
struct is_update_per_cycle_once : decltype(is_update_per_cycle_once_impl::check<T, U>(nullptr, nullptr)) {};
