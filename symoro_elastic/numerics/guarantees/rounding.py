"""Proven rounding errors of polynomials: each operation's error times the derivative of the result by it, on a grid.

**Lemma.** Let operation i of a program without quotients be wrong by e_i, |e_i| <= w_i u |exact value of the operation|,
z_i its value, a_i the derivative of the result by it. Then

    |computed - exact| <= u sum w_i |a_i| |z_i| + u sum w_i m(a_i) m(z_i) ((1 + u)^2k - 1)

where m are sums of magnitudes of the products that a_i and z_i are when written out, and k bounds how often one of them
is rounded. *Proof.* The computed values solve z~ = op(z~) + e. For a product, x~ y~ - x y = (x~ - x) y~ + x (y~ - y): the
differences obey a linear recursion, of which the result is sum b_i e_i, where b_i is a_i written out, with z~ in place of z
at some places; z~ written out is z with factors (1 + d), |d| <= u, at most k to a product. So b_i is within
((1 + u)^k - 1) m(a_i) of a_i, and likewise the value that e_i refers to of z_i.

The first sum is bounded on a grid: a_i z_i is a polynomial of the degrees of the result or less, and at each position
|a_i| |z_i| <= (sum of magnitudes of coefficients of the motion of a_i) (the same of z_i), the largest of products of fixed
combinations of the coefficients. A sum over i of largest values is the largest of sums, so the lemma of `axes.py` holds.
"""

from __future__ import annotations
