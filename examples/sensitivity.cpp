/* How the accelerations of planar_2r change with its second mass: dual numbers through the generated header.
 *
 *   symoro-elastic generate examples/planar_2r.toml --target cpp
 *   c++ -std=c++11 -Igenerated/planar_2r examples/sensitivity.cpp -o sensitivity && ./sensitivity
 */
#include <cmath>
#include <cstdio>

#include "planar_2r.hpp"

/* A number, and its derivative by the second mass. */
struct Dual {
    double value;
    double slope;
    Dual() : value(0.0), slope(0.0) {}
    explicit Dual(double x, double s = 0.0) : value(x), slope(s) {}
};

Dual operator-(Dual a) { return Dual(-a.value, -a.slope); }
Dual operator+(Dual a, Dual b) { return Dual(a.value + b.value, a.slope + b.slope); }
Dual operator-(Dual a, Dual b) { return Dual(a.value - b.value, a.slope - b.slope); }
Dual operator*(Dual a, Dual b) { return Dual(a.value*b.value, a.value*b.slope + a.slope*b.value); }
Dual operator/(Dual a, Dual b) { return Dual(a.value/b.value, (a.slope - a.value/b.value*b.slope)/b.value); }
Dual sin(Dual a) { return Dual(std::sin(a.value), std::cos(a.value)*a.slope); }
Dual cos(Dual a) { return Dual(std::cos(a.value), -std::sin(a.value)*a.slope); }

int main()
{
    const Dual q[planar_2r::joints] = {Dual(0.3), Dual(-0.8)};
    const Dual qd[planar_2r::joints] = {Dual(1.0), Dual(0.5)};
    const Dual tau[planar_2r::motors] = {Dual(2.0), Dual(0.1)};
    Dual p[planar_2r::parameters], qdd[planar_2r::joints];
    for (std::size_t k = 0; k < planar_2r::parameters; k++) {
        p[k] = Dual(planar_2r::defaults[k], k == planar_2r::p_m2 ? 1.0 : 0.0);
    }
    planar_2r::direct_dynamics(q, qd, tau, p, qdd);
    for (const Dual &x : qdd) {
        std::printf("%12.6f rad/s2, %12.6f rad/s2 for a kg more\n", x.value, x.slope);
    }
}
