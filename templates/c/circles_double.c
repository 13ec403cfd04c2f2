/* Sines and cosines of n angles, within 1.5 units in the last place up to LARGEST_ANGLE.
 *
 * x = k pi/2 + r with pi/2 in three parts, of which k times the first two are exact; polynomials in r; the last two
 * bits of k, read from the sum that rounds it, choose sine or cosine and the signs.
 */
INLINE void circles(size_t n, const double *restrict x, double *restrict sine, double *restrict cosine)
{
    int large = 0;
    for (size_t i = 0; i < n; i++)
        large |= !(fabs(x[i]) <= LARGEST_ANGLE);
    if (large) {
        for (size_t i = 0; i < n; i++) {
            sine[i] = sin(x[i]);
            cosine[i] = cos(x[i]);
        }
        return;
    }
    for (size_t i = 0; i < n; i++) {
        const double rounder = 0x1.8p52;
        const double rounded = x[i]*0x1.45f306dc9c883p-1 + rounder;
        const double k = rounded - rounder;
        const double t = x[i] - k*0x1.921fb544p+0, u = k*0x1.0b4611a6p-34, v = t - u;
        const double r = v + (((t - v) - u) - k*0x1.3198a2e037073p-69);
        const double z = r*r;
        const double s = r + r*z*(-0x1.5555555555555p-3 + z*(0x1.1111111110bb2p-7 + z*(-0x1.a01a019e83900p-13
            + z*(0x1.71de37965e0e8p-19 + z*(-0x1.ae600acd78df1p-26 + z*0x1.5e0b04aa9e9dbp-33)))));
        const double c = 1.0 - (0.5*z - z*z*(0x1.5555555555555p-5 + z*(-0x1.6c16c16c16967p-10 + z*(0x1.a01a019f4e9f7p-16
            + z*(-0x1.27e4fa17c076bp-22 + z*(0x1.1eeb68cb4c486p-29 + z*-0x1.907d8bf27a69cp-37))))));
        uint64_t quarter, bits_s, bits_c;
        memcpy(&quarter, &rounded, sizeof quarter);
        memcpy(&bits_s, &s, sizeof bits_s);
        memcpy(&bits_c, &c, sizeof bits_c);
        const uint64_t exchange = (0 - (quarter & 1)) & (bits_s ^ bits_c);
        bits_s ^= exchange ^ ((quarter & 2) << 62);
        bits_c ^= exchange ^ (((quarter + 1) & 2) << 62);
        memcpy(&sine[i], &bits_s, sizeof bits_s);
        memcpy(&cosine[i], &bits_c, sizeof bits_c);
    }
}
