/* Arithmetic on sums of two doubles, the second at most half a unit in the last place of the first: 106 bits.
 *
 * Products of floating point numbers may not be contracted into sums here, but the errors of products are found by
 * fma: fast where the processor has it (-mfma). A result beyond the range of doubles is NaN.
 */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("fp-contract=off")
#elif defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

INLINE double_double pair(double high, double low)
{
    const double_double x = {high, low};
    return x;
}

INLINE double pair_rounded(double_double x)
{
    return x.high;
}

INLINE double_double pair_negative(double_double x)
{
    return pair(-x.high, -x.low);
}

/* The exact sum of two doubles; the second form wants the larger one first. */
INLINE double_double pair_exact_sum(double a, double b)
{
    const double s = a + b, t = s - a;
    return pair(s, (a - (s - t)) + (b - t));
}

INLINE double_double pair_ordered_sum(double a, double b)
{
    const double s = a + b;
    return pair(s, b - (s - a));
}

INLINE double_double pair_exact_product(double a, double b)
{
    const double p = a*b;
    return pair(p, fma(a, b, -p));
}

INLINE double_double pair_sum(double_double a, double_double b)
{
    const double_double high = pair_exact_sum(a.high, b.high), low = pair_exact_sum(a.low, b.low);
    const double_double s = pair_ordered_sum(high.high, high.low + low.high);
    return pair_ordered_sum(s.high, s.low + low.low);
}

INLINE double_double pair_difference(double_double a, double_double b)
{
    return pair_sum(a, pair_negative(b));
}

INLINE double_double pair_product(double_double a, double_double b)
{
    const double_double p = pair_exact_product(a.high, b.high);
    return pair_ordered_sum(p.high, p.low + (a.high*b.low + a.low*b.high));
}

INLINE double_double pair_quotient(double_double a, double_double b)
{
    const double first = a.high/b.high;
    const double_double rest = pair_difference(a, pair_product(pair(first, 0.0), b));
    const double second = rest.high/b.high;
    const double_double last = pair_difference(rest, pair_product(pair(second, 0.0), b));
    return pair_sum(pair_ordered_sum(first, second), pair(last.high/b.high, 0.0));
}

INLINE double_double pair_square_root(double_double x)
{
    const double root = sqrt(x.high);
    if (root == 0.0)
        return pair(root, 0.0);
    return pair_ordered_sum(root, pair_difference(x, pair_exact_product(root, root)).high/(2.0*root));
}

INLINE double_double pair_sign(double_double x)
{
    return pair(x.high > 0.0 ? 1.0 : x.high < 0.0 ? -1.0 : x.high, 0.0);
}

INLINE double_double pair_polynomial(const double (*coefficients)[2], int terms, double_double z)
{
    double_double value = pair(0.0, 0.0);
    for (int k = terms - 1; k >= 0; k--)
        value = pair_sum(pair_product(value, z), pair(coefficients[k][0], coefficients[k][1]));
    return value;
}

/* Sine and cosine: x = k pi/2 + r with pi/2 in four doubles, Taylor's series in r. Beyond 2^50 rad, as far as a
 * state in double precision has any meaning, the library's values in double precision.
 */
APART void pair_turn(double_double x, double_double *sine, double_double *cosine)
{
    static const double half_pi[4] = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54, -0x1.f1976b7ed8fbcp-110, 0x1.4cf98e804177dp-164};
    static const double of_sine[][2] = {
    {-0x1.5555555555555p-3, -0x1.5555555555555p-57},
    {0x1.1111111111111p-7, 0x1.1111111111111p-63},
    {-0x1.a01a01a01a01ap-13, -0x1.a01a01a01a01ap-73},
    {0x1.71de3a556c734p-19, -0x1.c154f8ddc6c00p-73},
    {-0x1.ae64567f544e4p-26, 0x1.c062e06d1f209p-80},
    {0x1.6124613a86d09p-33, 0x1.f28e0cc748ebep-87},
    {-0x1.ae7f3e733b81fp-41, -0x1.1d8656b0ee8cbp-97},
    {0x1.952c77030ad4ap-49, 0x1.ac981465ddc6cp-103},
    {-0x1.2f49b46814157p-57, -0x1.2650f61dbdcb4p-112},
    {0x1.71b8ef6dcf572p-66, -0x1.d043ae40c4647p-120},
    {-0x1.761b41316381ap-75, 0x1.3423c7d91404fp-130},
    {0x1.3f3ccdd165fa9p-84, -0x1.58ddadf344487p-139},
    {-0x1.d1ab1c2dccea3p-94, -0x1.054d0c78aea14p-149}
    };
    static const double of_cosine[][2] = {
    {-0x1.0000000000000p-1, 0x0.0p+0},
    {0x1.5555555555555p-5, 0x1.5555555555555p-59},
    {-0x1.6c16c16c16c17p-10, 0x1.f49f49f49f49fp-65},
    {0x1.a01a01a01a01ap-16, 0x1.a01a01a01a01ap-76},
    {-0x1.27e4fb7789f5cp-22, -0x1.cbbc05b4fa99ap-76},
    {0x1.1eed8eff8d898p-29, -0x1.2aec959e14c06p-83},
    {-0x1.93974a8c07c9dp-37, -0x1.05d6f8a2efd1fp-92},
    {0x1.ae7f3e733b81fp-45, 0x1.1d8656b0ee8cbp-101},
    {-0x1.6827863b97d97p-53, -0x1.eec01221a8b0bp-107},
    {0x1.e542ba4020225p-62, 0x1.ea72b4afe3c2fp-120},
    {-0x1.0ce396db7f853p-70, 0x1.aebcdbd20331cp-124},
    {0x1.f2cf01972f578p-80, -0x1.9ada5fcc1ab14p-135},
    {-0x1.88e85fc6a4e5ap-89, 0x1.71c37ebd16540p-143},
    {0x1.0a18a2635085dp-98, 0x1.b9e2e28e1aa54p-153}
    };
    if (!(fabs(x.high) <= 0x1p50)) {
        *sine = pair(sin(x.high), 0.0);
        *cosine = pair(cos(x.high), 0.0);
        return;
    }
    const double k = floor(x.high*0x1.45f306dc9c883p-1 + 0.5);
    double_double r = x;
    for (int part = 0; part < 4; part++)
        r = pair_difference(r, pair_exact_product(k, half_pi[part]));
    const double_double z = pair_product(r, r);
    const double_double s = pair_sum(r, pair_product(pair_product(r, z), pair_polynomial(of_sine, 13, z)));
    const double_double c = pair_sum(pair(1.0, 0.0), pair_product(z, pair_polynomial(of_cosine, 14, z)));
    const int quarter = (int)(k - 4.0*floor(0.25*k));
    *sine = quarter & 1 ? c : s;
    *cosine = quarter & 1 ? s : c;
    if (quarter & 2)
        *sine = pair_negative(*sine);
    if ((quarter + 1) & 2)
        *cosine = pair_negative(*cosine);
}

INLINE double_double pair_sine(double_double x)
{
    double_double sine, cosine;
    pair_turn(x, &sine, &cosine);
    return sine;
}

INLINE double_double pair_cosine(double_double x)
{
    double_double sine, cosine;
    pair_turn(x, &sine, &cosine);
    return cosine;
}

/* The library's angle in double precision, and Newton's correction. */
INLINE double_double pair_arc_tangent(double_double y, double_double x)
{
    const double angle = atan2(y.high, x.high);
    double_double sine, cosine;
    pair_turn(pair(angle, 0.0), &sine, &cosine);
    const double_double across = pair_difference(pair_product(y, cosine), pair_product(x, sine));
    const double_double along = pair_sum(pair_product(x, cosine), pair_product(y, sine));
    return along.high > 0.0 ? pair_sum(pair(angle, 0.0), pair_quotient(across, along)) : pair(angle, 0.0);
}
