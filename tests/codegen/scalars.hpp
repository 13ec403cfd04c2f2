/* Scalar types to try generated headers with: nothing converts by itself, functions are found beside the type. */
#ifndef SCALARS_HPP
#define SCALARS_HPP

#include <cmath>
#include <cstdint>

namespace duals {

/* A value and its derivative. */
struct Dual {
    double x;
    double d;
    Dual() : x(0.0), d(0.0) {}
    explicit Dual(double value, double derivative = 0.0) : x(value), d(derivative) {}
    Dual &operator+=(const Dual &b) { x += b.x; d += b.d; return *this; }
    Dual &operator-=(const Dual &b) { x -= b.x; d -= b.d; return *this; }
    Dual &operator/=(const Dual &b) { d = (d - x/b.x*b.d)/b.x; x /= b.x; return *this; }
};

inline Dual operator-(const Dual &a) { return Dual(-a.x, -a.d); }
inline Dual operator+(Dual a, const Dual &b) { return a += b; }
inline Dual operator-(Dual a, const Dual &b) { return a -= b; }
inline Dual operator/(Dual a, const Dual &b) { return a /= b; }
inline Dual operator*(const Dual &a, const Dual &b) { return Dual(a.x*b.x, a.x*b.d + a.d*b.x); }
inline bool operator<(const Dual &a, const Dual &b) { return a.x < b.x; }
inline bool operator>(const Dual &a, const Dual &b) { return a.x > b.x; }
inline Dual sin(const Dual &a) { return Dual(std::sin(a.x), std::cos(a.x)*a.d); }
inline Dual cos(const Dual &a) { return Dual(std::cos(a.x), -std::sin(a.x)*a.d); }
inline Dual sqrt(const Dual &a) { return Dual(std::sqrt(a.x), 0.5*a.d/std::sqrt(a.x)); }

} // namespace duals

namespace fixed_point {

/* A number in units of 2^-32. */
class Fixed {
public:
    Fixed() : units(0) {}
    explicit Fixed(double value) : units(static_cast<std::int64_t>(std::llround(value*4294967296.0))) {}
    explicit operator double() const { return static_cast<double>(units)/4294967296.0; }
    friend Fixed operator-(Fixed a) { return of(-a.units); }
    friend Fixed operator+(Fixed a, Fixed b) { return of(a.units + b.units); }
    friend Fixed operator-(Fixed a, Fixed b) { return of(a.units - b.units); }
    friend Fixed operator*(Fixed a, Fixed b) { return of(static_cast<std::int64_t>((Long(a.units)*b.units) >> 32)); }
    friend Fixed operator/(Fixed a, Fixed b) { return of(static_cast<std::int64_t>((Long(a.units) << 32)/b.units)); }
    friend bool operator<(Fixed a, Fixed b) { return a.units < b.units; }
    friend bool operator>(Fixed a, Fixed b) { return a.units > b.units; }
    friend Fixed sin(Fixed a) { return Fixed(std::sin(double(a))); }
    friend Fixed cos(Fixed a) { return Fixed(std::cos(double(a))); }

private:
    __extension__ typedef __int128 Long;
    static Fixed of(std::int64_t units)
    {
        Fixed x;
        x.units = units;
        return x;
    }
    std::int64_t units;
};

} // namespace fixed_point

#endif
